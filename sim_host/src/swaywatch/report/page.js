"use strict";
// Draws the page's plots: light, dark, narrow and on paper; one zoom for all plots of a run; CSV.
(() => {
  const PAPER_WIDTH = 690; // CSS pixels between the margins of A4
  const PAPER_HEIGHT = 900; // of a plot, so that its heading fits on the sheet too
  const NARROW = 640;
  const DARK = { // colour on white -> colour on black; what is not named stays
    "#1f2937": "#e5e7eb", "#111827": "#e5e7eb", "black": "#e5e7eb", "#000": "#e5e7eb",
    "#000000": "#e5e7eb", "#0072B2": "#56b4e9", "#2563eb": "#6ea8ff", "#009E73": "#34c796",
    "#D55E00": "#ff8540", "#d64545": "#ff7b7b", "#6b7280": "#a3acb9",
  };
  const config = {
    displaylogo: false, responsive: false, showSendToCloud: false, plotlyServerURL: "",
    modeBarButtonsToRemove: ["sendChartToCloud", "select2d", "lasso2d", "autoScale2d"],
  };
  const wishes = window.matchMedia("(prefers-color-scheme: dark)");
  const plots = [];
  let printing = false;

  const unpack = async (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };

  // Numbers come as base64 of little-endian arrays.
  const KINDS = { f4: Float32Array, f8: Float64Array, i1: Int8Array, u1: Uint8Array,
    i2: Int16Array, u2: Uint16Array, i4: Int32Array, u4: Uint32Array };
  const numbers = (value) => {
    if (Array.isArray(value)) { return value.map(numbers); }
    if (value === null || typeof value !== "object") { return value; }
    if (typeof value.bdata === "string") {
      const bytes = Uint8Array.from(atob(value.bdata), (c) => c.charCodeAt(0));
      const flat = new KINDS[value.dtype](bytes.buffer);
      if (!value.shape) { return flat; }
      const [rows, columns] = String(value.shape).split(",").map(Number);
      return Array.from({ length: rows }, (_, i) => flat.subarray(i * columns, (i + 1) * columns));
    }
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, numbers(item)]));
  };

  const recoloured = (value) => {
    if (typeof value === "string") {
      if (DARK[value]) { return DARK[value]; }
      if (value.includes("style=")) {
        return value.replace(/#[0-9A-Fa-f]{6}/g, (colour) => DARK[colour] ?? colour);
      }
      const faint = /^rgba\((\d+),(\d+),(\d+),([\d.]+)\)$/.exec(value);
      if (!faint) { return value; }
      const name = "#" + faint.slice(1, 4).map((n) => Number(n).toString(16).padStart(2, "0")).join("");
      const key = Object.keys(DARK).find((k) => k.toLowerCase() === name);
      if (!key) { return value; }
      const to = DARK[key].match(/\w\w/g).map((pair) => parseInt(pair, 16));
      return `rgba(${to.join(",")},${faint[4]})`;
    }
    if (Array.isArray(value)) { return typeof value[0] === "number" ? value : value.map(recoloured); }
    if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) { return value; }
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, recoloured(item)]));
  };

  const inLines = (text) => { // a title of at most 44 characters a line
    const lines = [""];
    for (const word of text.split(" ")) {
      const longer = `${lines.at(-1)} ${word}`.trim();
      if (longer.length > 44) { lines.push(word); } else { lines[lines.length - 1] = longer; }
    }
    return lines.join("<br>");
  };

  const axesOf = (layout, letter) =>
    Object.keys(layout).filter((key) => new RegExp(`^${letter}axis\\d*$`).test(key));

  const look = (plot) => {
    const dark = wishes.matches && !printing;
    const least = Number(plot.holder.dataset.least || 0);
    const room = printing ? PAPER_WIDTH : plot.holder.clientWidth;
    const narrow = room < NARROW && least <= NARROW;
    const layout = dark ? recoloured(plot.layout) : structuredClone(plot.layout);
    let data = dark ? recoloured(plot.data) : plot.data;
    if (narrow) {
      data = data.map((trace) => (trace.colorbar?.orientation === "h"
        ? { ...trace, colorbar: { ...trace.colorbar, len: 0.9 } } : trace));
    }
    const ink = dark ? "#e5e7eb" : "#1f2937";
    Object.assign(layout, {
      width: printing ? PAPER_WIDTH : Math.max(room, least), autosize: false, uirevision: "page",
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      hoverlabel: { bgcolor: dark ? "#1b212b" : "#ffffff", font: { color: ink } },
    });
    layout.font = { ...layout.font, color: ink };
    if (printing) { layout.height = Math.min(layout.height ?? 450, PAPER_HEIGHT); }
    if (narrow && !printing) {
      layout.font.size = 12;
      layout.margin = { ...layout.margin, l: Math.min(layout.margin?.l ?? 64, 64), r: 10 };
      layout.dragmode = false; // a finger scrolls the page
      if (layout.title?.text) {
        layout.title = { ...layout.title, text: inLines(layout.title.text), font: { size: 13 },
          y: 1, yanchor: "top", pad: { t: 20 } };
        const lines = layout.title.text.split("<br>").length; // the legend stands below them
        const names = data.filter((t) => t.name && t.showlegend !== false).map((t) => t.name.length);
        const rows = names.reduce((sum, long) => sum + (long > 14 ? 1 : 0.5), 0);
        const above = Math.max((layout.margin.t ?? 60) + 18, 36 + 17 * lines + 22 * Math.ceil(rows));
        layout.height = (layout.height ?? 450) + above - (layout.margin.t ?? 60);
        layout.margin.t = above;
      }
    }
    if (layout.width > room && layout.title?.text) { // it scrolls: the title where it begins
      layout.title = { ...layout.title, text: inLines(layout.title.text), font: { size: 13 },
        x: 0, xanchor: "left", pad: { ...layout.title.pad, l: 4 } };
    }
    for (const letter of ["x", "y"]) {
      for (const key of axesOf(layout, letter)) {
        layout[key].gridcolor = dark ? "#2b3442" : "#e7eaee";
        layout[key].linecolor = dark ? "#5b6472" : "#9ca3af";
        layout[key].tickcolor = layout[key].linecolor;
        if (letter === "y" && layout[key].title?.text) { // beside the numbers, never over them
          layout[key].automargin = "left";
          layout[key].title.standoff = narrow ? 3 : 8;
        }
        if (plot.zoom && letter === "x" && plot.linked) {
          layout[key].range = plot.zoom; layout[key].autorange = false;
        }
      }
    }
    return [data, layout];
  };

  const draw = (plot) => {
    const [data, layout] = look(plot);
    plot.width = layout.width;
    return window.Plotly.react(plot.div, data, layout, config);
  };

  // --- one zoom for all plots of a run ---------------------------------------------------------
  let busy = false;
  const follow = (plot, change) => {
    if (busy || !plot.linked) { return; }
    const name = Object.keys(change).find((key) => /^xaxis\d*\.(range|autorange)/.test(key));
    if (!name) { return; }
    const axis = name.split(".")[0];
    const range = change[`${axis}.range`] ?? [change[`${axis}.range[0]`], change[`${axis}.range[1]`]];
    const zoom = change[`${axis}.autorange`] || range[0] === undefined ? null : range;
    busy = true;
    const others = plots.filter((other) => other.linked === plot.linked);
    Promise.all(others.map((other) => {
      other.zoom = zoom;
      const update = {};
      for (const key of axesOf(other.layout, "x")) {
        const whole = other.layout[key].range;
        if (zoom || whole) { update[`${key}.range`] = zoom || whole; }
        else { update[`${key}.autorange`] = true; }
      }
      return window.Plotly.relayout(other.div, update);
    })).finally(() => { busy = false; });
  };

  // --- CSV ------------------------------------------------------------------------------------
  const cell = (value) => {
    if (value === null || value === undefined || Number.isNaN(value)) { return ""; }
    const text = typeof value === "number" ? String(Number(value.toPrecision(9))) : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const plain = (text) => String(text ?? "").replace(/<br>/g, " ").replace(/<[^>]*>/g, "");
  const titleOf = (plot, trace, letter) => {
    const id = String(trace[`${letter}axis`] ?? letter);
    const key = `${letter}axis${id.slice(1)}`;
    const own = plain(plot.layout[key]?.title?.text);
    return own || (letter === "x" ? plot.holder.dataset.x : "") || letter;
  };
  const tableOf = (plot) => {
    const columns = [];
    for (const trace of plot.data) {
      if (trace.hoverinfo === "skip") { continue; }
      const x = titleOf(plot, trace, "x");
      const y = titleOf(plot, trace, "y");
      const name = plain(trace.name);
      if (trace.type === "heatmap") {
        const [xs, ys] = [Array.from(trace.x), Array.from(trace.y)];
        columns.push([x, ys.flatMap(() => xs)], [y, ys.flatMap((v) => xs.map(() => v))],
          [plain(trace.colorbar?.title?.text) || "value",
            Array.from(trace.z).flatMap((row) => Array.from(row))]);
        continue;
      }
      columns.push([x, Array.from(trace.x ?? [])]);
      columns.push([name ? `${name}: ${y}` : y, Array.from(trace.y ?? [])]);
      const error = trace.error_y?.array ?? (trace.customdata && !Array.isArray(trace.customdata[0])
        && ArrayBuffer.isView(trace.customdata) ? trace.customdata : null);
      if (error) { columns.push([`${name}: error`, Array.from(error)]); }
    }
    const rows = Math.max(0, ...columns.map(([, values]) => values.length));
    const lines = [columns.map(([head]) => cell(head)).join(",")];
    for (let row = 0; row < rows; row += 1) {
      lines.push(columns.map(([, values]) => cell(values[row])).join(","));
    }
    return `${lines.join("\n")}\n`;
  };
  const save = (plot) => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([tableOf(plot)], { type: "text/csv" }));
    link.download = `${plot.holder.dataset.name || "plot"}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  // --- start ----------------------------------------------------------------------------------
  const start = async () => {
    const library = document.getElementById("library");
    if (!library) { return; }
    const script = document.createElement("script");
    script.textContent = await unpack(library.textContent);
    document.head.append(script);
    for (const holder of document.querySelectorAll("figure.plot")) {
      const packed = holder.querySelector("script");
      const content = numbers(JSON.parse(await unpack(packed.textContent)));
      packed.remove();
      const plot = { holder, div: holder.querySelector(".draw"), data: content.data,
        layout: content.layout, linked: holder.dataset.run || "", zoom: null, width: 0 };
      plots.push(plot);
      await draw(plot);
      plot.div.on("plotly_relayout", (change) => follow(plot, change));
      holder.querySelector("button").addEventListener("click", () => save(plot));
      await new Promise((done) => { setTimeout(done, 0); });
    }
    document.documentElement.dataset.drawn = String(plots.length);
  };
  const again = () => plots.forEach((plot) => { draw(plot); });
  const onPaper = (now) => () => { if (printing !== now) { printing = now; again(); } };
  wishes.addEventListener("change", again);
  window.addEventListener("beforeprint", onPaper(true));
  window.addEventListener("afterprint", onPaper(false));
  let waiting = 0;
  window.addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      if (!printing) {
        plots.filter((p) => Math.abs(p.holder.clientWidth - p.width) > 4).forEach((p) => { draw(p); });
      }
    }, 150);
  });
  const show = (name, content) => { // another content for the plot of that name
    const plot = plots.find((other) => other.holder.dataset.name === name);
    Object.assign(plot, { data: numbers(content.data), layout: numbers(content.layout) });
    return draw(plot);
  };
  window.swaywatch = { plots, tableOf, show };
  start().catch((error) => {
    const text = typeof DecompressionStream === "undefined"
      ? "The plots need a browser of 2023 or newer." : `The plots could not be drawn: ${error}`;
    document.querySelector("main").insertAdjacentHTML("afterbegin",
      "<p class='error' id='no-plots'></p>");
    document.getElementById("no-plots").textContent = text;
    console.error(error);
  });
})();
