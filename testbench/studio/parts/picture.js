// A Plotly figure that is drawn when it comes near the screen. The figure is a string: plain data that Vue leaves alone.
const plotly = () =>
  window.Plotly
    ? Promise.resolve(window.Plotly)
    : new Promise((resolve) =>
        document.getElementById("plotly").addEventListener("load", () => resolve(window.Plotly)),
      );

export default {
  template: "<div></div>",
  props: { figure: String },
  mounted() {
    this.near = false;
    this.stale = true;
    this.watcher = new IntersectionObserver(
      ([seen]) => {
        this.near = seen.isIntersecting;
        this.draw();
      },
      { rootMargin: "300px" },
    );
    this.watcher.observe(this.$el);
    this.sizes = new ResizeObserver(() => this.fit());
    this.sizes.observe(this.$el);
    this.print = () => {
      this.near = true;
      this.draw();
    };
    window.addEventListener("beforeprint", this.print);
  },
  unmounted() {
    this.watcher.disconnect();
    this.sizes.disconnect();
    window.removeEventListener("beforeprint", this.print);
    if (this.width) window.Plotly.purge(this.$el);
  },
  watch: {
    figure() {
      this.stale = true;
      this.draw();
    },
  },
  methods: {
    async draw() {
      if (!this.near || !this.stale) return;
      this.stale = false;
      const Plotly = await plotly();
      if (!this.$el.isConnected) return;
      const figure = JSON.parse(this.figure);
      const first = !this.width;
      this.width = this.$el.clientWidth;
      const { data, layout } = window.forNarrow(figure, this.width);
      this.$el.style.minHeight = `${layout.height}px`;
      await Plotly.react(this.$el, data, layout, figure.config);
      // Drawings on buttons that have names, and plotly's ruler, are nothing to a screen reader.
      document.querySelectorAll(".modebar svg, #js-plotly-tester").forEach((svg) => (svg.ariaHidden = "true"));
      if (first) this.$el.on("plotly_relayout", (change) => this.$emit("zoom", change));
      this.$el.dataset.drawn = 1 + Number(this.$el.dataset.drawn ?? 0);
      this.$emit("drawn");
    },
    look(start, end) {
      const whole = { "xaxis.autorange": true };
      window.Plotly.relayout(this.$el, start === null ? whole : { "xaxis.range[0]": start, "xaxis.range[1]": end });
    },
    fit() {
      if (!this.width || this.width === this.$el.clientWidth || !this.$el.clientWidth) return;
      const narrow = [this.width, this.$el.clientWidth].some((width) => width < 560);
      this.width = this.$el.clientWidth;
      if (narrow) {
        this.stale = true;
        this.draw();
      } else window.Plotly.Plots.resize(this.$el);
    },
  },
};
