// @ts-check
"use strict";
/* Lines and boundaries through the deciding rises that Python has tabulated. Nothing here knows the page. */

/**
 * @typedef {{normal_load: number, velocity: number, friction: number | null}} Measurement
 * @typedef {{axis: string, names: number[], inputs: Object<string, (number|string)[]>}} Surfaces
 * @typedef {[number, number, number, number, number, number, string]} Packed
 * @typedef {{points: Object<string, Packed>, stored: number, shape?: [number, number],
 *   block?: [number, number], extent?: [number, (number | null)]}} Fields
 * @typedef {{load: number, velocity: number, powers: [number, number], temperatures: number[],
 *   logarithms: number[]}} Film
 * @typedef {{title: string, name: string, conditions: Conditions, friction_heat: boolean,
 *   measured: Measurement[], chosen: boolean, loads: number[], velocities: number[],
 *   quantiles: number[], wear_rates: number[], bulk_ratios: number[], shares: number[],
 *   surfaces: Surfaces | null,
 *   done: number, status: string, asked: string,
 *   moments: string, moment_times: string, rises: string, numbers: Object<string, string>,
 *   decisive: string, deciding: string, outcomes: string[],
 *   range: {velocity: [number, number], load: [number, number]},
 *   messages: Object<string, string>, warnings: Object<string, string[]>, fields: Fields,
 *   friction_band: [number, number] | null, film: Film | null,
 *   record: Object<string, string>}} Content what pipeline.figures.page.content gives
 * @typedef {[number, number]} Ends least and greatest place that a transition may have
 * @typedef {{at: number[], outcome: number[], ends: Ends[], computed: Ends[]}} Crossings
 * @typedef {{velocity: Crossings, load: Crossings, missing: number}} Boundary
 * @typedef {{rise: number, moment: number}} Worst
 * @typedef {{rises: number[][][], along: Line[][], across: Line[][], fine: number[],
 *   columns: Line[][]}} Decisive decisive rises, and lines through them by surface
 */

const BAND = [0.1, 0.5, 0.9];
const POINT_DONE = 1;
const POINT_FAILED = 2;

/** The sweep of a page. */
class Sweep {
  /** @param {Content} content */
  constructor(content) {
    const { loads, velocities } = content;
    this.loads = loads;
    /** Those at which the contacts have the wear rate that is shown. */
    this.velocities = velocities;
    this.content = content;
    this.quantiles = content.quantiles;
    this.continued = content.chosen;
    /** Number of surfaces; each has a place for every load and velocity. */
    this.surfaces = content.surfaces ? content.surfaces.names.length : 1;
    this.plane = loads.length * velocities.length;
    this.status = new Int8Array(bytes(content.status));
    this.asked = new Uint8Array(bytes(content.asked));
    this.moments = new Int32Array(bytes(content.moments));
    this.times = new Float32Array(bytes(content.moment_times));
    this.range = content.range;
    this.shares = content.shares;
    this.everyDeciding = new Float64Array(bytes(content.decisive));
    this.everyRise = new Float32Array(bytes(content.rises));
    this.wearRate = content.conditions.wear_rate ?? NaN;
    /** Rise that decides at each failing share. */
    this.deciding = this.table(this.everyDeciding, this.shares.length);
    /** Quantiles of the rise, to look at. */
    this.rises = this.table(this.everyRise, this.quantiles.length);
    /** @type {Object<string, Float32Array>} */
    this.numbers = {};
    for (const name in content.numbers) {
      this.numbers[name] = new Float32Array(bytes(content.numbers[name]));
    }
    /** First moment of each place. */
    this.begins = new Int32Array(this.moments.length);
    for (let k = 1; k < this.moments.length; k++) {
      this.begins[k] = this.begins[k - 1] + this.moments[k - 1];
    }
    /** Lines by share and bulk ratio. @type {Map<string, Decisive>} */
    this.kept = new Map();
  }

  /**
   * Number of a point at the wear rate that is shown; NaN where only that of its own is known.
   * @param {string} name @param {number} place
   */
  number(name, place) {
    const ratio = (this.content.conditions.wear_rate ?? NaN) / this.wearRate;
    const value = this.numbers[name]?.[place] ?? NaN;
    if (!Number.isFinite(ratio) || ratio === 1) return value;
    if (name === "sliding_distance") return ratio * value;
    return name === "pin_heat_share" ? NaN : value;
  }

  /**
   * Rises at the wear rate that is shown.
   * @param {Float64Array | Float32Array} values @param {number} width
   */
  table(values, width) {
    const { bulk_ratios, wear_rates } = this.content;
    const at = atWearRate(values, wear_rates, this.wearRate, bulk_ratios.length * width);
    return new Table(at, bulk_ratios, width);
  }

  /**
   * Take the sweep at a wear rate, where its points answer for several (pipeline.at_wear_rate);
   * whether it was at another one before.
   * @param {number | undefined} rate
   */
  takeWearRate(rate) {
    const own = this.content.conditions.wear_rate;
    if (rate === undefined || own === undefined || rate === this.wearRate) return false;
    this.wearRate = rate;
    const [low, high] = this.content.range.velocity;
    /** @type {[number, number]} */
    const velocity = [(low * own) / rate, (high * own) / rate];
    this.velocities = this.content.velocities.map((each) => (each * own) / rate);
    this.range = { ...this.content.range, velocity };
    this.deciding = this.table(this.everyDeciding, this.shares.length);
    this.rises = this.table(this.everyRise, this.quantiles.length);
    this.kept.clear();
    return true;
  }

  /** @param {number} surface @param {number} i of the load @param {number} j of the velocity */
  place(surface, i, j) {
    return surface * this.plane + i * this.velocities.length + j;
  }

  /**
   * Decisive rise of a point [K] and the moment of it; NaN and −1 where it is not known.
   * @param {number} place @param {Conditions} conditions @returns {Worst}
   */
  worst(place, conditions) {
    const ratio = bulkRatio(conditions);
    let found = { rise: NaN, moment: -1 };
    for (let k = 0; k < this.moments[place]; k++) {
      const moment = this.begins[place] + k;
      const rise = linear(this.shares, this.deciding.row(moment, ratio), conditions.failing_share);
      if (!(rise <= found.rise)) found = { rise, moment };
    }
    return found;
  }

  /**
   * Decisive rises, and the lines through them.
   * @param {Conditions} conditions @returns {Decisive}
   */
  decisive(conditions) {
    const key = `${conditions.failing_share} ${bulkRatio(conditions)}`;
    const kept = this.kept.get(key);
    if (kept) return kept;
    const { loads, velocities } = this;
    /** @type {number[][][]} */
    const rises = [];
    for (let surface = 0; surface < this.surfaces; surface++) {
      rises.push(
        loads.map((_load, i) =>
          velocities.map((_velocity, j) => this.worst(this.place(surface, i, j), conditions).rise),
        ),
      );
    }
    const along = rises.map((rows) => rows.map((row) => lineOf(velocities, row)));
    const across = rises.map((rows) =>
      velocities.map((_, j) => lineOf(loads, rows.map((row) => row[j]))),
    );
    const fine = this.fineVelocities();
    const columns = along.map((rows) =>
      fine.map((at) => lineOf(loads, rows.map((row) => valueAt(row, at)))),
    );
    const found = { rises, along, across, fine, columns };
    if (this.kept.size > 10) this.kept.clear();
    this.kept.set(key, found);
    return found;
  }

  /** Velocities at which to draw the boundary: those of the sweep, and some between them. */
  fineVelocities() {
    const { velocities } = this;
    const between = Math.max(2, Math.round(240 / velocities.length / Math.sqrt(this.surfaces)));
    const fine = velocities.slice(0, 1);
    for (let j = 1; j < velocities.length; j++) {
      const [low, high] = [velocities[j - 1], velocities[j]];
      for (let k = 1; k < between; k++) fine.push(low + ((high - low) * k) / between);
      fine.push(high);
    }
    return fine;
  }

  /**
   * Critical velocity by load and critical load by velocity, of one surface.
   * @param {number} surface @param {Conditions} conditions @returns {Boundary}
   */
  boundary(surface, conditions) {
    const limit = riseLimit(conditions);
    const { along, across, rises } = this.decisive(conditions);
    let missing = 0;
    rises[surface].forEach((row, i) =>
      row.forEach((rise, j) => {
        if (Number.isNaN(rise) && this.asked[this.place(surface, i, j)]) missing++;
      }),
    );
    return {
      velocity: crossings(along[surface], limit, this.range.velocity),
      load: crossings(across[surface], limit, this.range.load),
      missing,
    };
  }

  /**
   * Boundaries to draw: critical load at each of the fine velocities and velocity at each load,
   * infinite beyond the sweep and NaN where not known. Of one surface; or of all of them the lower
   * edge of the band, the median and the upper edge, with which the tables agree.
   * @param {number | null} surface @param {Conditions} conditions
   */
  drawn(surface, conditions) {
    const { columns, along, fine } = this.decisive(conditions);
    const limit = riseLimit(conditions);
    const upwards = this.continued
      ? along.map((rows) =>
          fine.map((at) => lineOf(this.loads, rows.map((row) => certainAt(row, at, limit)))),
        )
      : columns;
    const { load, velocity } = this.range;
    /** @type {[Line[][], [number, number]][]} */
    const sides = [[upwards, load], [along, velocity]];
    const [loads, velocities] = sides.map(([lines, range]) =>
      (surface === null ? lines : [lines[surface]]).map((each) => crossings(each, limit, range).ends),
    );
    const over = (/** @type {Ends[][]} */ each, /** @type {number} */ share) =>
      each[0].map((_, k) => quantileOfEnds(each.map((values) => values[k]), share));
    return (surface === null ? BAND : [0.5]).map((share) => ({
      loads: over(loads, share),
      velocities: over(velocities, share),
    }));
  }

  /**
   * Decisive rise at any load and velocity within the sweep [K], interpolated along the velocity
   * at each load, and beyond its points by their power law, and then along the load; whether it lies
   * within the points; and the lines through that place, without what lies beyond them.
   * @param {number} surface @param {number} load @param {number} velocity
   * @param {Conditions} conditions
   */
  lines(surface, load, velocity, conditions) {
    const { along, across } = this.decisive(conditions);
    const column = along[surface].map((line) => valueAt(line, velocity, true));
    const within = along[surface].map((line) => valueAt(line, velocity));
    const limit = riseLimit(conditions);
    const rise = valueAt(lineOf(this.loads, column), load);
    const isWithin = Number.isFinite(valueAt(lineOf(this.loads, within), load));
    const between = (
      /** @type {number[]} */ x,
      /** @type {number[]} */ y,
      /** @type {number} */ at,
    ) => (isWithin ? withPoint(x, y, at, rise) : lineOf(x, y));
    const [i, j] = [this.loads.indexOf(load), this.velocities.indexOf(velocity)];
    /** Computed points, and these going on where they are certainly mild or severe. */
    let alongVelocity = [along[surface][i], along[surface][i]];
    if (i < 0) {
      const own = across[surface].map((line) => valueAt(line, load));
      const going = this.velocities.map((at) =>
        valueAt(lineOf(this.loads, along[surface].map((line) => certainAt(line, at, limit))), load),
      );
      alongVelocity = [own, going].map((row) => between(this.velocities, row, velocity));
    }
    let alongLoad = [across[surface][j], across[surface][j]];
    if (j < 0) {
      const going = along[surface].map((line) => certainAt(line, velocity, limit));
      alongLoad = [within, going].map((line) => between(this.loads, line, load));
    }
    return { rise, isWithin, alongVelocity, alongLoad };
  }
}

/** Bytes of base64. @param {string} text */
function bytes(text) {
  const letters = atob(text);
  const found = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) found[k] = letters.charCodeAt(k);
  return found.buffer;
}
