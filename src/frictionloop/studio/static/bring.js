// A picture or a recording laid on the plate: dropped or chosen, and asked about first, for its file does not say.
const $ = (id) => document.getElementById(id), MOST_BYTES = 4 * 1024 * 1024;

export function bringing(link) {
  const dialog = $("bring"), form = $("bring-form"), why = $("bring-why"), card = $("plate-card");
  let file = null, kind = "", picture = null;
  $("open-effect").onclick = () => $("effect-file").click();
  $("effect-file").onchange = () => { take($("effect-file").files[0]); $("effect-file").value = ""; };
  for (const name of ["dragenter", "dragover"]) card.addEventListener(name, (event) => { event.preventDefault(); card.classList.add("dropping"); });
  for (const name of ["dragleave", "drop"]) card.addEventListener(name, (event) => { event.preventDefault(); card.classList.remove("dropping"); });
  card.addEventListener("drop", (event) => take(event.dataTransfer.files[0]));
  // A file that misses the plate must not take the page away.
  for (const name of ["dragover", "drop"]) addEventListener(name, (event) => event.preventDefault());

  async function take(chosen) {
    if (!chosen) return;
    file = chosen;
    kind = /\.png$/i.test(file.name) ? "png" : /\.wav$/i.test(file.name) ? "wav" : "";
    if (!kind) return link.tell("refused", { why: `${file.name}: a PNG or a WAV can be laid on the plate; other files are read by frictionloop effect import.` });
    if (file.size > MOST_BYTES) return link.tell("refused", { why: `${file.name}: ${(file.size / 1048576).toFixed(1)} MiB; at most 4.` });
    for (const part of form.querySelectorAll("[data-kind]")) {
      part.hidden = part.dataset.kind !== kind;
      for (const input of part.querySelectorAll("input")) input.disabled = part.hidden;
    }
    form.reset();
    over();
    why.textContent = "";
    $("bring-title").textContent = file.name;
    picture = null;
    if (kind === "png") {
      $("bring-picture").src = URL.createObjectURL(file);
      await $("bring-picture").decode().then(() => { picture = $("bring-picture"); }, () => {});
    }
    size();
    dialog.showModal();
  }
  function size() {
    const mm = Number(form.elements.mm_per_pixel.value);
    $("bring-size").textContent = picture && mm > 0
      ? `${picture.naturalWidth} × ${picture.naturalHeight} pixels will be ${(mm * picture.naturalWidth).toFixed(1)} × ${(mm * picture.naturalHeight).toFixed(1)} mm.`
      : picture ? `${picture.naturalWidth} × ${picture.naturalHeight} pixels.` : "";
  }
  form.elements.mm_per_pixel.oninput = size;
  // Played over time a recording needs no speed.
  const over = () => {
    const label = form.querySelector("[data-over]");
    label.hidden = kind === "wav" && form.elements.over.value === "time";
    label.querySelector("input").disabled = kind !== "wav" || label.hidden;
  };
  for (const each of form.elements.over) each.onchange = over;
  $("bring-cancel").onclick = () => dialog.close();
  dialog.addEventListener("close", () => URL.revokeObjectURL($("bring-picture").src));
  form.onsubmit = async (event) => {
    event.preventDefault();
    why.textContent = "Reading …";
    try {
      const told = await link.bring(kind, Object.fromEntries(new FormData(form)), file);
      dialog.close();
      link.tell("said", { why: `${file.name}: ${told}.` });
    } catch (error) {
      why.textContent = error.message;
    }
  };
}
