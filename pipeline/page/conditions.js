/* The form of conditions: sliders, fields, and faults of typed values. */

/** Why a changed condition is invalid; else "". @param {Conditions} conditions @param {Control} control */
function faultOf(conditions, { name, least, most, fault }) {
  const value = conditions[name] ?? NaN;
  if (!Number.isFinite(value)) return "give a number such as 0.12";
  if (value < (least ?? -Infinity) || value > (most ?? Infinity)) return fault;
  const { bulk_temperature, disk_temperature = bulk_temperature, critical_temperature } = conditions;
  const warmest = Math.max(bulk_temperature, disk_temperature);
  const isMelted = critical_temperature !== null && critical_temperature <= warmest;
  return isMelted ? "the critical temperature must lie above the bulk temperature" : "";
}

function listenToConditions() {
  for (const control of content.controls) {
    input(control.name).addEventListener("change", () => change(control, input(control.name)));
    const slider = input(`${control.name}-range`);
    slider.addEventListener("input", () => change(control, slider));
    showControl(control);
  }
  element("reset").addEventListener("click", () => {
    chosen.conditions = { ...content.conditions };
    content.controls.forEach(showControl);
    update();
  });
}

/** Number typed as text, with a decimal comma or point; NaN if it is none. The field is not of type number,
 * as some browsers silently drop a comma. @param {string} text */
function typed(text) {
  const isThousands = /^[+-]?[1-9]\d{0,2},\d{3}$/.test(text.trim());
  const plain = text.trim().replace("−", "-").replace(",", isThousands ? "," : ".");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}

/** Take a value from a field or slider. @param {Control} control @param {HTMLInputElement} source */
function change(control, source) {
  const value = typed(source.value) - control.offset;
  const conditions = { ...chosen.conditions, [control.name]: value };
  const fault = faultOf(conditions, control);
  showFault(control, fault);
  if (fault) return;
  chosen.conditions = conditions;
  showControl(control);
  update();
}

/** Show a fault beside its field. @param {Control} control @param {string} fault empty for none */
function showFault({ name }, fault) {
  element(`${name}-fault`).textContent = fault;
  input(name).setAttribute("aria-invalid", fault ? "true" : "false");
}

/** Show a condition in its slider and its field. @param {Control} control */
function showControl(control) {
  const value = chosen.conditions[control.name] ?? null;
  const text = value === null ? "" : String(Number((value + control.offset).toPrecision(9)));
  for (const target of [input(control.name), input(`${control.name}-range`)]) target.value = text;
  showFault(control, "");
}

/** How conditions act on rises at friction 1: coldest bulk temperature [K], factor on the rise, difference
 * of bulk temperatures over that factor [K], and rise above which wear is severe [K]. Without friction
 * different bulk temperatures still warm one body; their ratio is then the largest one stored.
 * @param {Conditions} conditions */
function heatOf(conditions) {
  const { friction, bulk_temperature: pin, disk_temperature: disk = pin } = conditions;
  const [difference, coldest] = [disk - pin, Math.min(pin, disk)];
  const heating = friction * (1 + conditions.unmodelled_rise);
  const factor = Math.max(heating, Math.abs(difference) / Math.max(...content.bulk_ratios, 1));
  const { critical_temperature: critical } = conditions;
  const limit = critical === null ? NaN : (critical - coldest) / factor;
  return { coldest, factor, ratio: difference && difference / factor, limit };
}
