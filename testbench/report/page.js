// Each figure is drawn when it comes near the screen, so that a long report opens at once.
const figures = JSON.parse(document.getElementById("figures").textContent);
const draw = (holder) => {
  if (holder.dataset.drawn) return;
  holder.dataset.drawn = "yes";
  const figure = figures[holder.id];
  const { data, layout } = forNarrow(figure, holder.clientWidth);
  holder.style.height = `${layout.height}px`;
  Plotly.newPlot(holder, data, layout, figures.config);
};
const holders = [...document.querySelectorAll(".plot")];
const watcher = new IntersectionObserver(
  (seen) => seen.filter((entry) => entry.isIntersecting).forEach((entry) => draw(entry.target)),
  { rootMargin: "600px" },
);
holders.forEach((holder) => watcher.observe(holder));
window.addEventListener("beforeprint", () => holders.forEach(draw));
