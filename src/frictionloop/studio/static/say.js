// Text that stays is left alone: to write the same again lets a browser lay the page out again.
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
