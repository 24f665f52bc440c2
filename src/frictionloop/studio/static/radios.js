// Buttons of which one is chosen: one stop of the tab key, arrows go on, as radio buttons do.
export function radios(group, choose) {
  const buttons = () => [...group.querySelectorAll("[role=radio]")];
  function check(button) {
    for (const each of buttons()) {
      each.setAttribute("aria-checked", each === button);
      each.tabIndex = each === button || (!button && each === buttons()[0]) ? 0 : -1;
    }
  }
  group.addEventListener("click", (event) => {
    const button = event.target.closest("[role=radio]");
    if (!button) return;
    check(button);
    choose(button);
  });
  group.addEventListener("keydown", (event) => {
    const way = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key], all = buttons();
    if (!way) return;
    const next = all[(all.indexOf(document.activeElement) + way + all.length) % all.length];
    event.preventDefault();
    next.focus();
    next.click();
  });
  check(buttons().find((button) => button.getAttribute("aria-checked") === "true"));
  return check;
}
