// Which curves of a flight stand in a panel, and what each looks like.

const HUES = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8a8a8a"];
const DASHES = { reference: [6, 4], command: [4, 3], limit: [2, 3] };
const COMMON = ["reference", "limit"]; // the same for all flights

/** How a curve stands in a legend: as a piece of it, dashes and all. */
export const MARKERS = {
  width: 0,
  fill: (plot, k) => {
    const { stroke, dash = [1] } = plot.series[k], hue = stroke(plot, k);
    let at = 0;
    const stops = dash.flatMap((length, i) => {
      const colour = i % 2 ? "transparent" : hue;
      return [`${colour} ${at}px`, `${colour} ${at += length}px`];
    });
    return `repeating-linear-gradient(90deg, ${stops.join()})`;
  },
};

export const hueOf = (number) => HUES[number % HUES.length];

/** The curves of one flight in the panel of a title: all where it is alone, else those that compare it. */
export function curvesOf({ panels, name, colour }, title, alone, first) {
  const panel = panels.find((one) => one.title === title);
  if (!panel) return [];
  let hue = 0;
  const hues = new Map();
  return panel.curves
    .filter((curve) => curve.seen === "both" || curve.seen === (alone ? "alone" : "compared"))
    .filter((curve) => alone || first || !COMMON.includes(curve.role))
    .map((curve) => {
      const kin = curve.label.replace(/ command$/, "");
      if (curve.role === "truth" && !hues.has(kin)) hues.set(kin, hueOf(hue++));
      const plain = { reference: "#8a8a8a", limit: "#8a8a8a", estimate: "#E69F00" }[curve.role];
      return {
        unit: panel.unit,
        label: alone ? curve.label : COMMON.includes(curve.role) ? curve.label : name,
        stroke: alone ? plain ?? hues.get(kin) ?? colour : COMMON.includes(curve.role) ? "#8a8a8a" : colour,
        dash: DASHES[curve.role],
        width: curve.role === "estimate" ? 1 : 1.6,
        column: curve.column,
      };
    });
}
