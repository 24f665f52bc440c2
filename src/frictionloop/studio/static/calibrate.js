// True scale: the outline of a bank card is drawn, and made as large as the card in the hand.
import { CSS_MM } from "./plate.js";

const $ = (id) => document.getElementById(id);
const WIDE_MM = 85.6, HIGH_MM = 53.98, ROUND_PX = 44;  // ISO/IEC 7810, ID-1

export function calibrating(plate) {
  const dialog = $("scale"), card = $("scale-card"), slider = $("scale-px");
  const show = (scale) => {
    // On a phone a card is wider than the screen: its outline stands upright.
    const upright = WIDE_MM * scale > dialog.clientWidth - ROUND_PX;
    card.style.width = `${(upright ? HIGH_MM : WIDE_MM) * scale}px`;
    card.style.height = `${(upright ? WIDE_MM : HIGH_MM) * scale}px`;
    slider.nextElementSibling.value = `${scale.toFixed(2)} px/mm`;
  };
  const told = () => {
    $("scale-open").textContent = localStorage.getItem("px-per-mm") ? "True scale ✓" : "True scale …";
  };
  slider.oninput = () => show(Number(slider.value));
  $("scale-open").onclick = () => {
    slider.value = plate.scale;
    dialog.showModal();
    show(plate.scale);
  };
  $("scale-keep").onclick = () => { plate.setScale(Number(slider.value)); told(); dialog.close(); };
  $("scale-reset").onclick = () => { plate.setScale(CSS_MM); localStorage.removeItem("px-per-mm"); told(); dialog.close(); };
  $("scale-cancel").onclick = () => dialog.close();
  told();
}
