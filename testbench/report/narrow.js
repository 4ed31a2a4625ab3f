// On a narrow screen, panels that stand side by side are stacked: each gets the whole width and a height of its own.
const NARROW_PX = 560, PANEL_PX = 230, GAP_PX = 58;

window.forNarrow = ({ data, layout }, width) => {
  const narrow = width < NARROW_PX;
  if (narrow) data = data.map((trace) => (trace.showlegend ? { ...trace, name: wrapped(trace.name, width) } : trace));
  const panels = narrow ? panelsOf(layout) : [];
  const columns = new Set(panels.map((panel) => panel.left.toFixed(2)));
  const margin = narrow || matchMedia("(hover: none)").matches ? roomFor({ data, layout }, width, narrow) : {};
  if (columns.size < 2) return { data, layout: taller(layout, margin) };
  panels.sort((one, other) => other.top - one.top || one.left - other.left);
  const inner = panels.length * PANEL_PX + (panels.length - 1) * GAP_PX;
  const stacked = { ...layout, ...margin };
  panels.forEach((panel, index) => {
    const low = Math.max(0, 1 - (index * (PANEL_PX + GAP_PX) + PANEL_PX) / inner);
    panel.now = [low, Math.min(1, low + PANEL_PX / inner)];
    stacked[panel.x] = { ...layout[panel.x], domain: [0, 1], anchor: panel.yRef };
    stacked[panel.y] = { ...layout[panel.y], domain: panel.now, anchor: panel.xRef };
  });
  stacked.annotations = (layout.annotations ?? []).map((note) => moved(note, panels));
  stacked.height = inner + stacked.margin.t + stacked.margin.b;
  return { data: data.map((trace) => barBeside(trace, panels)), layout: stacked };
};

// What the margin takes is added to the height, so that the panels stay as high as they were.
const taller = (layout, { margin }) =>
  margin ? { ...layout, margin, height: layout.height + margin.t - (layout.margin?.t ?? 0) } : layout;

// A colour bar stands beside its own panel.
const barBeside = (trace, panels) => {
  const panel = trace.colorbar && panels.find(({ yRef }) => yRef === (trace.yaxis ?? "y"));
  if (!panel) return trace;
  const [low, high] = panel.now;
  return { ...trace, colorbar: { ...trace.colorbar, x: 1.01, y: (low + high) / 2, yanchor: "middle", len: high - low } };
};

// Each vertical axis with the horizontal one that it is drawn on.
const panelsOf = (layout) =>
  Object.keys(layout)
    .filter((key) => key.startsWith("yaxis"))
    .map((y) => {
      const xRef = layout[y].anchor ?? "x";
      const x = xRef.replace("x", "xaxis");
      const across = layout[x]?.domain ?? [0, 1];
      const up = layout[y].domain ?? [0, 1];
      return { y, x, xRef, yRef: y.replace("yaxis", "y"), left: across[0], right: across[1], top: up[1] };
    });

// Its tools always stand on a screen that is touched: they get a row of their own, and so does each line of the legend.
const TOOLS_PX = 44, LINE_PX = 20, SIGN_PX = 46, LETTER_PX = 7;
const roomFor = ({ data, layout }, width, narrow) => {
  const [most, mostRight] = narrow ? [120, 110] : [Infinity, Infinity];
  const [left, right] = [Math.min(layout.margin?.l ?? 64, most), Math.min(layout.margin?.r ?? 20, mostRight)];
  const top = TOOLS_PX + LINE_PX * legendLines({ data, layout }, width - left - right);
  return { margin: { ...layout.margin, t: Math.max(layout.margin?.t ?? 0, top), l: left, r: right } };
};

// A name in a legend that is longer than the screen is wide goes on below.
const wrapped = (name = "", width) => {
  const lines = [];
  for (const word of name.split(" ")) {
    const longer = [...lines.slice(-1), word].join(" ");
    if (lines.length && SIGN_PX + LETTER_PX * longer.length < width) lines.pop();
    lines.push(SIGN_PX + LETTER_PX * longer.length < width ? longer : word);
  }
  return lines.join("<br>");
};
// How many lines the entries of a legend above the panels take: they stand in columns as wide as the longest.
const legendLines = ({ data, layout }, width) => {
  const names = data.filter((trace) => trace.showlegend).map((trace) => trace.name ?? "");
  if (!names.length || (layout.legend?.y ?? 1) < 1) return 0;
  const lines = names.flatMap((name) => name.split("<br>"));
  const columns = Math.floor(width / (SIGN_PX + LETTER_PX * Math.max(...lines.map((line) => line.length))));
  return Math.ceil(lines.length / Math.max(1, columns));
};

// A note on the paper goes where its panel went; one that is tied to axes goes with them by itself.
const moved = (note, panels) => {
  if (note.xref !== "paper" || note.yref !== "paper") return note;
  const home = panels.reduce((best, panel) => (Math.abs(panel.left - note.x) < Math.abs(best.left - note.x) ? panel : best));
  return { ...note, x: 0, xanchor: "left", y: home.now[1], yanchor: "bottom" };
};
