// @ts-check
"use strict";
/* The conditions: sliders and fields, and what is wrong with what was typed. */

/**
 * @typedef {{name: Exclude<keyof Conditions, "criterion">, label: string, low: number, high: number,
 *   step: number, show: (value: number) => number, read: (shown: number) => number}} Control
 */

/** The sweep was computed for bulk temperatures that may differ. */
function hasTwoBulks() {
  return content.bulk_ratios.length > 1;
}

/** A share of the contact decides. */
function hasShare() {
  return content.shares.length > 1;
}

/** @type {Control[]} */
const EVERY_CONTROL = [
  {
    name: "friction",
    label: "friction coefficient",
    low: 0,
    high: Math.max(0.3, Math.ceil(20 * content.conditions.friction) / 10),
    step: 0.001,
    show: (value) => value,
    read: (value) => value,
  },
  ...[
    {
      name: /** @type {const} */ ("bulk_temperature"),
      label: `bulk temperature${hasTwoBulks() ? " of the pin" : ""} [°C]`,
      high: 200,
    },
    ...(hasTwoBulks()
      ? [
          {
            name: /** @type {const} */ ("disk_temperature"),
            label: "bulk temperature of the disk [°C]",
            high: 200,
          },
        ]
      : []),
    {
      name: /** @type {const} */ ("critical_temperature"),
      label: "critical temperature [°C]",
      high: 400,
    },
  ].map((each) => ({
    ...each,
    low: Math.min(0, 10 * Math.floor(((content.conditions[each.name] ?? 300) - 273.15) / 10)),
    high: Math.max(each.high, Math.ceil(1.5 * ((content.conditions[each.name] ?? 0) - 273.15))),
    step: 0.5,
    show: (/** @type {number} */ value) => value - ZERO_CELSIUS,
    read: (/** @type {number} */ value) => value + ZERO_CELSIUS,
  })),
  {
    name: "failing_share",
    label: "failing share of the contact [%]",
    low: 0,
    high: Math.max(50, Math.ceil(100 * content.conditions.failing_share)),
    step: 0.5,
    show: (/** @type {number} */ value) => 100 * value,
    read: (/** @type {number} */ value) => value / 100,
  },
  {
    name: "wear_rate",
    label: "specific wear rate [10⁻⁶ mm³/(N m)]",
    low: 1e15 * Math.min(...content.wear_rates),
    high: 1e15 * Math.max(...content.wear_rates),
    step: 0.01,
    show: (value) => 1e15 * value,
    read: (value) => value / 1e15,
  },
];
const CONTROLS = EVERY_CONTROL.filter(({ name }) =>
  name === "wear_rate" ? content.wear_rates.length : name !== "failing_share" || hasShare(),
);

/**
 * Fault of conditions; empty if there is none.
 * @param {Conditions} conditions @param {Control["name"]} name of the one that was changed
 */
function faultOf(conditions, name) {
  const { friction, bulk_temperature, critical_temperature, failing_share } = conditions;
  const { disk_temperature = bulk_temperature } = conditions;
  const value = conditions[name] ?? null;
  if (value === null || !Number.isFinite(value)) return "give a number";
  if (friction < 0) return "friction must be at least 0";
  if (friction > 0 && !content.friction_heat) {
    return "the sweep was computed without friction, and so without any heat";
  }
  for (const bulk of [bulk_temperature, disk_temperature]) {
    if (bulk < 220 || bulk > 900) return "from −53.15 to 626.85 °C";
  }
  const warmest = Math.max(bulk_temperature, disk_temperature);
  if (critical_temperature !== null && critical_temperature <= warmest) {
    return "the critical temperature must lie above the bulk temperature";
  }
  const [least, most] = [Math.min(...content.wear_rates), Math.max(...content.wear_rates)];
  if (name === "wear_rate" && (value < least * (1 - 1e-9) || value > most * (1 + 1e-9))) {
    return `from ${shown(1e15 * least, 6)} to ${shown(1e15 * most, 6)}, for which the sweep was computed`;
  }
  if (failing_share < 0 || failing_share >= 1) return "from 0 (the maximum) to below 100 %";
  return "";
}

function makeConditions() {
  const form = element("conditions");
  form.addEventListener("submit", (event) => event.preventDefault());
  for (const control of CONTROLS) {
    const { name, label, low, high, step } = control;
    const range = { type: "range", id: `${name}-range`, min: `${low}`, max: `${high}` };
    const slider = html("input", { ...range, step: `${step}`, "aria-label": label });
    const field = html("input", { type: "text", inputmode: "decimal", id: name });
    field.setAttribute("aria-describedby", `${name}-fault`);
    form.append(
      html(
        "div",
        { class: "control" },
        html("label", { for: name }, label),
        html("div", { class: "pair" }, slider, field),
        html("p", { class: "fault", id: `${name}-fault`, role: "alert" }),
      ),
    );
    for (const each of [slider, field]) {
      each.addEventListener("input", () => change(control, /** @type {HTMLInputElement} */ (each)));
    }
  }
  if (content.surfaces && sweep.surfaces > 1) form.append(...surfaceChoice());
  element("reset").addEventListener("click", () => {
    chosen.conditions = { ...content.conditions };
    for (const control of CONTROLS) showControl(control, null);
    update();
  });
  for (const control of CONTROLS) showControl(control, null);
}

/** @returns {HTMLElement[]} */
function surfaceChoice() {
  const select = html("select", { id: "surface" });
  select.append(html("option", { value: "" }, `all ${sweep.surfaces} surfaces`));
  for (let k = 0; k < sweep.surfaces; k++) {
    select.append(html("option", { value: `${k}` }, surfaceName(k)));
  }
  select.addEventListener("change", () => {
    const { value } = /** @type {HTMLSelectElement} */ (select);
    chosen.surface = value === "" ? null : Number(value);
    update();
  });
  return [html("label", { for: "surface" }, "surface: "), select];
}

/**
 * The number that was typed, NaN if it is none. A field of type number would not do: some browsers
 * drop a decimal comma unseen.
 * @param {string} text
 */
function typed(text) {
  const plain = text.trim().replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}

/** Fault of text that is no number. @param {string} text */
function commaFault(text) {
  const pointed = text.trim().replace(",", ".");
  const isComma = text.includes(",") && Number.isFinite(typed(pointed));
  return isComma ? `write a decimal point, as in ${pointed}` : "";
}

/** Take over what was typed or moved. @param {Control} control @param {HTMLInputElement} source */
function change(control, source) {
  const conditions = { ...chosen.conditions, [control.name]: control.read(typed(source.value)) };
  const fault = commaFault(source.value) || faultOf(conditions, control.name);
  element(`${control.name}-fault`).textContent = fault;
  input(control.name).setAttribute("aria-invalid", fault ? "true" : "false");
  if (fault) return;
  chosen.conditions = conditions;
  showControl(control, source);
  update();
}

/** Show a condition in its slider and its field, but not where it comes from. */
function showControl(
  /** @type {Control} */ control,
  /** @type {HTMLInputElement | null} */ source,
) {
  const value = chosen.conditions[control.name] ?? null;
  const text = value === null ? "" : String(Number(control.show(value).toPrecision(9)));
  for (const id of [control.name, `${control.name}-range`]) {
    const each = input(id);
    if (each !== source) each.value = text;
  }
  input(`${control.name}-range`).setAttribute("aria-valuetext", text);
  if (source) return;
  element(`${control.name}-fault`).textContent = "";
  input(control.name).setAttribute("aria-invalid", "false");
}

/** The wear rate that is shown, where there are several. */
function rateText() {
  const { wear_rate } = chosen.conditions;
  return wear_rate === undefined ? "" : `, wear rate ${shown(1e15 * wear_rate, 6)} × 10⁻⁶ mm³/(N m)`;
}

function conditionsText() {
  const { friction, bulk_temperature, critical_temperature, failing_share } = chosen.conditions;
  const critical = critical_temperature === null ? "not known" : celsius(critical_temperature, 6);
  const decisive = hasShare()
    ? `failing share ${shown(100 * failing_share, 6)} %`
    : `criterion ${content.conditions.criterion}`;
  const { disk_temperature } = chosen.conditions;
  const disk = disk_temperature === undefined ? "" : ` (pin) and ${celsius(disk_temperature, 6)} (disk)`;
  return (
    `friction ${shown(friction, 6)}, bulk ${celsius(bulk_temperature, 6)}${disk}, ` +
    `critical ${critical}, ${decisive}${rateText()}`
  );
}
