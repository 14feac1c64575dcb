"use strict";
// Asks for what is known by now, and draws it into the report's own plots.
(() => {
  const box = document.getElementById("live-alarm");
  const kinds = { normal: "good", notice: "near", warning: "bad", critical: "bad" };
  let lost = 0;
  const put = (id, content) => { document.getElementById(id).innerHTML = content; };
  const say = (kind, text) => {
    box.className = `verdict ${kind}`;
    box.firstElementChild.textContent = text;
  };
  const show = async (state) => {
    document.getElementById("live-trailer").textContent = state.trailer;
    if (!state.estimates) { return; }
    say(kinds[state.alarm] ?? "", `Alarm: ${state.alarm}`);
    put("live-verdict", state.verdict);
    put("live-numbers", state.numbers);
    for (const [name, figure] of Object.entries(state.figures)) {
      const holder = document.querySelector(`[data-live='${name}']`);
      holder.hidden = !figure;
      if (figure) { await window.swaywatch.show(name, JSON.parse(figure)); }
    }
    document.documentElement.dataset.estimates = String(state.estimates);
  };
  const turn = async () => {
    try {
      if (document.documentElement.dataset.drawn) {
        const answer = await fetch("/state", { cache: "no-store" });
        await show(await answer.json());
        lost = 0;
      }
    } catch (error) {
      lost += 1;
      if (lost === 3) { say("", "swaywatch monitor has ended; this is what it saw last."); }
    }
    setTimeout(turn, 1000);
  };
  turn();
})();
