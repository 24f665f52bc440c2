// Light, dark, or as the system has it: set before the first picture, so that nothing flashes.
(() => {
  const dark = matchMedia("(prefers-color-scheme: dark)"), looks = ["system", "light", "dark"];
  let chosen = localStorage.getItem("look") ?? "system";
  function apply() {
    const look = chosen === "system" ? (dark.matches ? "dark" : "light") : chosen;
    document.documentElement.dataset.look = look;
    const button = document.getElementById("look");
    if (button) {
      button.textContent = { system: "◐ System", light: "○ Light", dark: "● Dark" }[chosen];
      button.setAttribute("aria-label", `Colours: ${chosen}. Change.`);
    }
    dispatchEvent(new Event("look"));
  }
  dark.addEventListener("change", apply);
  addEventListener("DOMContentLoaded", () => {
    document.getElementById("look").onclick = () => {
      chosen = looks[(looks.indexOf(chosen) + 1) % looks.length];
      localStorage.setItem("look", chosen);
      apply();
    };
    apply();
  });
  apply();
})();
