// Opens a file: a bench (TOML) is put in force, a recorded run (HDF5) is played on a page of its own.
const $ = (id) => document.getElementById(id), MOST_BYTES = { toml: 256 * 1024, h5: 64 * 1024 * 1024 };

export function opening(link) {
  $("open-file").onclick = () => $("file").click();
  $("file").onchange = async () => {
    const file = $("file").files[0];
    $("file").value = "";
    if (!file) return;
    const most = MOST_BYTES[file.name.split(".").pop().toLowerCase()];
    if (!most || file.size > most) {
      const why = most ? `${(file.size / 1048576).toFixed(1)} MiB; at most ${(most / 1048576).toFixed(2)}` : "a bench (.toml) or a recorded run (.h5) can be opened";
      return link.tell("refused", { why: `${file.name}: ${why}.` });
    }
    const query = new URLSearchParams(location.search);
    query.set("name", file.name);
    const answer = await fetch(`/open?${query}`, { method: "POST", headers: { "X-Studio-Page": link.page }, body: file });
    const told = await answer.json().catch(() => ({ why: "The studio did not answer." }));
    if (!answer.ok) return link.tell("refused", { why: told.why });
    if (told.go) location.assign(told.go + location.search);
    else link.tell("said", { why: `${told.told}.` });
  };
}
