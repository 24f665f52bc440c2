// The tour: each step sets the page up, asks for one thing to try, and says when it has been done.
import { STEPS } from "./tour-steps.js";

export function touring(link, open, card, show) {
  let at = -1, values = {};
  // What a step can ask for: how much the finger has slid, how many fingers were taken, what the loop is.
  const page = { slid: false, fingers: 0, beyond: null, value: (path) => values[path] };
  const title = card.querySelector("h2"), text = card.querySelector(".told"), task = card.querySelector(".task"), count = card.querySelector(".count");
  const done = card.querySelector(".done"), [back, next, end] = ["back", "next", "end"].map((name) => card.querySelector(`[data-tour=${name}]`));
  let settled = false, touched = 0;

  function go(step) {
    if (at < 0) link.ask("tour", { on: true });
    at = step;
    card.hidden = at < 0;
    if (card.hidden) {
      // What was on the plate before the tour is there again.
      link.ask("tour", { on: false });
      show(["open_n", "closed_n", "asked_n"], "controller", false);
      open.focus();
      return;
    }
    const { title: name, told, task: asked, effect, values: wanted, signals, box, crowd } = STEPS[at];
    Object.assign(page, { slid: false, fingers: 0, beyond: null });
    [settled, touched] = [false, 0];
    title.textContent = name;
    text.textContent = told;
    task.textContent = asked;
    done.textContent = "";
    count.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    next.textContent = at === STEPS.length - 1 ? "Done" : "Next";
    link.ask("effect", { name: effect });
    link.ask("set", { values: wanted });
    show(signals, box, Boolean(crowd));
    title.focus({ preventScroll: true });
    card.scrollIntoView({ block: "nearest" });
  }
  function look() {
    if (at >= 0 && settled && !done.textContent && STEPS[at].done(page)) done.textContent = "✓ Done: go on when you like.";
  }
  link.addEventListener("system", ({ detail }) => {
    values = Object.fromEntries(Object.values(detail.panels).flat().map((field) => [field.path, field.value]));
    settled ||= at >= 0 && Object.entries(STEPS[at].values).every(([path, value]) => (values[path] ?? value) === value);
    page.beyond = null;
    look();
  });
  link.addEventListener("reach", ({ detail }) => { page.beyond = detail.shares?.beyond ?? null; look(); });
  link.addEventListener("slid", ({ detail }) => { page.slid ||= ++touched > 20; if (detail) look(); });
  link.addEventListener("taken", () => { page.fingers++; look(); });
  open.onclick = () => go(0);
  back.onclick = () => go(at - 1);
  next.onclick = () => go(at === STEPS.length - 1 ? -1 : at + 1);
  end.onclick = () => go(-1);
}
