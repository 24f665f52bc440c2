// What restores this loop elsewhere: an address, a file, Python, a command; and what an address restores here.
const $ = (id) => document.getElementById(id);

export function sharing(link) {
  const words = {};
  link.addEventListener("system", ({ detail }) => {
    const packed = detail.differs && btoa(unescape(encodeURIComponent(JSON.stringify(detail.differs))));
    words.address = packed ? `${location.href.split(/[?#]/)[0]}#${packed}` : "";
    document.querySelector("[data-copy=address]").disabled = !packed;
    $("copied").textContent = packed ? "Copy what restores this loop:" : "This effect is too large for an address: save the TOML file.";
    words.python = detail.python;
    words.command = detail.command;
    $("as-python").textContent = detail.python;
    $("as-command").textContent = detail.command;
  });
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.onclick = async () => {
      const text = words[button.dataset.copy];
      try {
        await navigator.clipboard.writeText(text);
        $("copied").textContent = "Copied.";
      } catch {
        $("copied").textContent = text;
      }
    };
  }
  let asked = location.hash.slice(1);
  link.addEventListener("status", ({ detail }) => {
    if (!asked || !detail.drives) return;
    try {
      link.ask("set", { values: JSON.parse(decodeURIComponent(escape(atob(asked)))) });
    } catch {
      $("status").textContent = "The address holds no loop that this studio can read.";
    }
    asked = "";
    history.replaceState(null, "", location.pathname + location.search);
  });
  $("undo").onclick = () => link.ask("undo");
  addEventListener("keydown", (event) => {
    if (event.key === "z" && (event.ctrlKey || event.metaKey) && !/^(INPUT|TEXTAREA)$/.test(event.target.tagName)) link.ask("undo");
  });
}
