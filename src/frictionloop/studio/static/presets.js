// Presets: one press puts a loop or a finger in force, as the server has them.
const $ = (id) => document.getElementById(id);

export function presets(link) {
  $("presets-open").onclick = () => {
    const open = $("presets").hidden;
    $("presets").hidden = !open;
    $("presets-open").setAttribute("aria-expanded", open);
  };
  link.addEventListener("hello", ({ detail }) => {
    $("presets").replaceChildren(...detail.presets.map(({ name, told }) => {
      const button = document.createElement("button");
      button.textContent = name;
      button.title = told;
      button.onclick = () => { link.ask("preset", { name }); link.tell("said", { why: told }); };
      return button;
    }));
  });
}
