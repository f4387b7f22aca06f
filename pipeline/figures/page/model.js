// @ts-check
"use strict";
/* Lines and boundaries through the deciding rises that Python has tabulated. Nothing here knows the page. */

/**
 * @typedef {{normal_load: number, velocity: number, friction: number | null}} Measurement
 * @typedef {[number, number, number, number, number, number, string]} Packed
 * @typedef {{points: Object<string, Packed>, stored: number, shape?: [number, number],
 *   block?: [number, number], extent?: [number, (number | null)]}} Fields
 * @typedef {{load: number, velocity: number, powers: [number, number], temperatures: number[],
 *   logarithms: number[]}} Film
 * @typedef {{name: ControlName, factor: number, offset: number, least: number | null,
 *   most: number | null, fault: string}} Control
 * @typedef {"friction" | "bulk_temperature" | "disk_temperature" | "critical_temperature"
 *   | "failing_share" | "wear_rate"} ControlName
 * @typedef {{label: string, unit: string, power: number | null, values: string}} Numbers
 * @typedef {{title: string, name: string, conditions: Conditions, controls: Control[],
 *   measured: Measurement[], chosen: boolean, loads: number[], velocities: number[],
 *   quantiles: number[], wear_rates: number[], bulk_ratios: number[], shares: number[],
 *   surfaces: number[] | null, status: string, asked: string, moments: string,
 *   moment_times: string, rises: string, decisive: string, numbers: Numbers[], deciding: string,
 *   errors: string, outcomes: {velocity: string[], load: string[]},
 *   range: {velocity: Ends, load: Ends}, messages: Object<string, string>,
 *   fields: Fields, friction_band: Ends | null, film: Film | null}} Content result of
 *   pipeline.figures.page.content
 * @typedef {{rises: number[][][], isMissing: boolean[][][], along: Line[][], across: Line[][],
 *   fine: number[], columns: Line[][]}} Decisive decisive rises, points that were asked for and
 *   have none, and lines through them by surface
 */

const POINT_DONE = 1;
const POINT_FAILED = 2;

/** The sweep of a page. */
class Sweep {
  /** @param {Content} content */
  constructor(content) {
    const { loads, velocities } = content;
    this.content = content;
    this.loads = loads;
    /** Those at which the contacts have the wear rate that is shown. */
    this.velocities = velocities;
    /** @type {{velocity: Ends, load: Ends}} */
    this.range = content.range;
    /** Number of surfaces; each has a place for every load and velocity. */
    this.surfaces = content.surfaces?.length ?? 1;
    this.plane = loads.length * velocities.length;
    this.status = new Int8Array(bytes(content.status));
    this.asked = new Uint8Array(bytes(content.asked));
    this.moments = new Int32Array(bytes(content.moments));
    this.times = new Float32Array(bytes(content.moment_times));
    /** Relative errors of the rise by surface, on and between the loads, and the velocities. */
    this.errors = new Float32Array(bytes(content.errors));
    this.numbers = content.numbers.map(({ values }) => new Float32Array(bytes(values)));
    this.everyDeciding = new Float64Array(bytes(content.decisive));
    this.everyRise = new Float32Array(bytes(content.rises));
    /** Wear rate over the sweep's own. */
    this.rateRatio = 1;
    /** Deciding rises by moment, bulk ratio and failing share. */
    this.deciding = this.atRate(this.everyDeciding);
    /** Quantiles of the rise by moment and bulk ratio, to look at. */
    this.rises = this.atRate(this.everyRise);
    /** First moment of each place. */
    this.begins = new Int32Array(this.moments.length);
    for (let k = 1; k < this.moments.length; k++) {
      this.begins[k] = this.begins[k - 1] + this.moments[k - 1];
    }
    /** Lines by share and bulk ratio. @type {Map<string, Decisive>} */
    this.kept = new Map();
  }

  /**
   * Rises at the wear rate that is shown, of those at several: by the power law between these.
   * @param {Float64Array | Float32Array} values by moment, wear rate and the rest
   * @returns {ArrayLike<number>}
   */
  atRate(values) {
    const { wear_rates: rates, conditions } = this.content;
    if (!rates.length) return values;
    const rate = (conditions.wear_rate ?? NaN) * this.rateRatio;
    const rest = values.length / rates.length / Math.max(sum([...this.moments]), 1);
    return Float64Array.from({ length: values.length / rates.length }, (_, k) => {
      const begin = Math.floor(k / rest) * rates.length * rest + (k % rest);
      return valueAt(lineOf(rates, rates.map((_rate, r) => values[begin + r * rest])), rate);
    });
  }

  /**
   * Take the sweep at a wear rate, where its points answer for several (pipeline.at_wear_rate);
   * true if it was at another one before.
   * @param {number | undefined} rate
   */
  takeWearRate(rate) {
    const ratio = (rate ?? NaN) / (this.content.conditions.wear_rate ?? NaN);
    if (Number.isNaN(ratio) || ratio === this.rateRatio) return false;
    this.rateRatio = ratio;
    const [low, high] = this.content.range.velocity;
    this.range = { ...this.range, velocity: [low / ratio, high / ratio] };
    this.velocities = this.content.velocities.map((velocity) => velocity / ratio);
    this.deciding = this.atRate(this.everyDeciding);
    this.rises = this.atRate(this.everyRise);
    this.kept.clear();
    return true;
  }

  /**
   * Row of a table of rises above the colder body at a moment, linear between the bulk ratios [K].
   * @param {ArrayLike<number>} values @param {number} width @param {number} moment @param {number} ratio
   */
  row(values, width, moment, ratio) {
    const { bulk_ratios: ratios } = this.content;
    const high = Math.min(above(ratios, ratio), ratios.length - 1);
    const low = Math.max(high - 1, 0);
    const weight = high > low ? (ratio - ratios[low]) / (ratios[high] - ratios[low]) : 0;
    const begin = moment * ratios.length * width;
    return Array.from({ length: width }, (_, k) => {
      const value = values[begin + low * width + k];
      return weight === 0 ? value : (1 - weight) * value + weight * values[begin + high * width + k];
    });
  }

  /** @param {number} surface @param {number} i of the load @param {number} j of the velocity */
  place(surface, i, j) {
    return surface * this.plane + i * this.velocities.length + j;
  }

  /**
   * Decisive rise of a point [K] and the moment of it; NaN and −1 where it is not known.
   * @param {number} place @param {Conditions} conditions
   */
  worst(place, conditions) {
    const { shares } = this.content;
    const ratio = bulkRatio(conditions);
    let worst = { rise: NaN, moment: -1 };
    for (let k = 0; k < this.moments[place]; k++) {
      const moment = this.begins[place] + k;
      const row = this.row(this.deciding, shares.length, moment, ratio);
      const rise = linear(shares, row, conditions.failing_share);
      if (!(rise <= worst.rise)) worst = { rise, moment };
    }
    return worst;
  }

  /** Decisive rises, and the lines through them. @param {Conditions} conditions @returns {Decisive} */
  decisive(conditions) {
    const key = `${conditions.failing_share} ${bulkRatio(conditions)}`;
    const kept = this.kept.get(key);
    if (kept) return kept;
    const { loads, velocities } = this;
    const rises = Array.from({ length: this.surfaces }, (_, surface) =>
      loads.map((_load, i) =>
        velocities.map((_velocity, j) => this.worst(this.place(surface, i, j), conditions).rise),
      ),
    );
    const isMissing = rises.map((rows, surface) =>
      rows.map((row, i) =>
        row.map((rise, j) => Number.isNaN(rise) && this.asked[this.place(surface, i, j)] !== 0),
      ),
    );
    const along = rises.map((rows) => rows.map((row) => lineOf(velocities, row)));
    const across = rises.map((rows) =>
      velocities.map((_, j) => lineOf(loads, rows.map((row) => row[j]))),
    );
    const fine = this.fineVelocities();
    const columns = along.map((lines) =>
      fine.map((velocity) => lineOf(loads, lines.map((line) => valueAt(line, velocity)))),
    );
    const decisive = { rises, isMissing, along, across, fine, columns };
    if (this.kept.size > 10) this.kept.clear();
    this.kept.set(key, decisive);
    return decisive;
  }

  /**
   * Velocities at which points of some loads are missing, and loads at which points of some
   * velocities are, given by their indices.
   * @param {number} surface @param {Conditions} conditions
   */
  gaps(surface, conditions) {
    const isMissing = this.decisive(conditions).isMissing[surface];
    return {
      velocity: (/** @type {number[]} */ rows) =>
        this.velocities.filter((_, j) => rows.some((i) => isMissing[i]?.[j])),
      load: (/** @type {number[]} */ columns) =>
        this.loads.filter((_, i) => columns.some((j) => isMissing[i][j])),
    };
  }

  /** Velocities at which to draw the boundary: those of the sweep, and some between them. */
  fineVelocities() {
    const { velocities } = this;
    const between = Math.max(2, Math.round(240 / velocities.length / Math.sqrt(this.surfaces)));
    return velocities.flatMap((high, j) => {
      if (j === 0) return [high];
      const low = velocities[j - 1];
      return Array.from({ length: between }, (_, k) =>
        k + 1 < between ? low + ((high - low) * (k + 1)) / between : high,
      );
    });
  }

  /**
   * Critical velocity by load and critical load by velocity over surfaces, and the number of
   * points that are missing.
   * @param {number[]} surfaces @param {Conditions} conditions
   */
  boundary(surfaces, conditions) {
    const limit = riseLimit(conditions);
    const { along, across, isMissing } = this.decisive(conditions);
    const over = (/** @type {Line[][]} */ lines, /** @type {"velocity" | "load"} */ axis) =>
      lines[0].map((_, k) =>
        summaryOf(
          surfaces.map((s) =>
            transitionAlong(lines[s][k], limit, this.range[axis], this.gaps(s, conditions)[axis]([k])),
          ),
        ),
      );
    return {
      velocity: over(along, "velocity"),
      load: over(across, "load"),
      missing: surfaces.flatMap((surface) => isMissing[surface].flat()).filter(Boolean).length,
    };
  }

  /**
   * Boundaries to draw: critical load at each of the fine velocities, infinite beyond the sweep and
   * NaN where not known. Of one surface; or of several the lower edge of the band, the median and
   * the upper edge.
   * @param {number[]} surfaces @param {Conditions} conditions
   */
  drawn(surfaces, conditions) {
    const { columns, along, fine } = this.decisive(conditions);
    const limit = riseLimit(conditions);
    const column = (/** @type {number} */ surface, /** @type {number} */ k) =>
      this.content.chosen
        ? lineOf(this.loads, along[surface].map((line) => certainAt(line, fine[k], limit)))
        : columns[surface][k];
    const ends = fine.map((_, k) =>
      surfaces.map((surface) => transitionAlong(column(surface, k), limit, this.range.load).ends),
    );
    const shares = surfaces.length > 1 ? BAND : [0.5];
    return shares.map((share) => ends.map((pairs) => quantileOfEnds(pairs, share)));
  }

  /**
   * Decisive rise at any load and velocity within the sweep [K], interpolated along the velocity
   * at each load, and beyond its points by their power law, and then along the load; true if it lies
   * within the points; and the transitions along both lines through that place.
   * @param {number} surface @param {number} load @param {number} velocity
   * @param {Conditions} conditions
   */
  margin(surface, load, velocity, conditions) {
    const { along, across } = this.decisive(conditions);
    const { loads, velocities, range } = this;
    const limit = riseLimit(conditions);
    const within = along[surface].map((line) => valueAt(line, velocity));
    const rise = valueAt(lineOf(loads, along[surface].map((line) => valueAt(line, velocity, true))), load);
    const isWithin = Number.isFinite(valueAt(lineOf(loads, within), load));
    const through = (/** @type {number[]} */ x, /** @type {number[]} */ y, /** @type {number} */ place) =>
      isWithin ? withPoint(x, y, place, rise) : lineOf(x, y);
    const certain = (/** @type {number} */ other) =>
      along[surface].map((line) => certainAt(line, other, limit));
    const [i, j] = [loads.indexOf(load), velocities.indexOf(velocity)];
    /** Computed points, and these going on where they are certainly mild or severe. */
    let alongVelocity = [along[surface][i]];
    if (i < 0) {
      const computed = across[surface].map((line) => valueAt(line, load));
      const going = velocities.map((other) => valueAt(lineOf(loads, certain(other)), load));
      alongVelocity = [computed, going].map((row) => through(velocities, row, velocity));
    }
    let alongLoad = [across[surface][j]];
    if (j < 0) alongLoad = [within, certain(velocity)].map((row) => through(loads, row, load));
    const gaps = this.gaps(surface, conditions);
    return {
      rise,
      isWithin,
      velocity: this.surest(alongVelocity, limit, range.velocity, gaps.velocity(beside(loads, load))),
      load: this.surest(alongLoad, limit, range.load, gaps.load(beside(velocities, velocity))),
    };
  }

  /**
   * Transition along the last line if it crosses, else along the first, that of computed points.
   * @param {Line[]} lines @param {number} limit @param {Ends} range @param {number[]} gaps
   */
  surest(lines, limit, range, gaps) {
    const going = transitionAlong(lines[lines.length - 1], limit, range, gaps, lines[0].x);
    return going.outcome === CROSSES ? going : transitionAlong(lines[0], limit, range);
  }
}

/** Bytes of base64. @param {string} text */
function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}
