// @ts-check
"use strict";
/* The deciding rise of a sweep, which Python has tabulated on a fine plane. Nothing here knows the page. */

/**
 * @typedef {{normal_load: number, velocity: number, friction: number | null,
 *   bulk_temperature?: number, outcome?: "mild" | "severe"}} Measurement
 * @typedef {[number, number, number, number, string, string, string]} Packed
 * @typedef {{points: Object<string, Packed>, stored: number, scales: string[], note: string,
 *   aspect: number}} Fields
 * @typedef {{name: ControlName, factor: number, offset: number, least: number | null,
 *   most: number | null, fault: string}} Control
 * @typedef {"friction" | "bulk_temperature" | "disk_temperature" | "critical_temperature"
 *   | "failing_share"} ControlName
 * @typedef {{label: string, unit: string, values: string}} Numbers
 * @typedef {{title: string, name: string, conditions: Conditions, controls: Control[],
 *   measured: Measurement[], chosen: boolean, loads: number[], velocities: number[],
 *   fine: {velocity: number[], load: number[]}, parts: {velocity: number, load: number},
 *   friction_factors: number[],
 *   lines: {velocity: string, load: string}, bridged: {velocity: string, load: string},
 *   missing: number[],
 *   quantiles: number[], bulk_ratios: number[], shares: number[],
 *   course: {steps: number, loads: string, rises: string, own: string},
 *   surfaces: number[] | null, status: string, asked: string, times: string, rises: string,
 *   numbers: Numbers[], deciding: string, errors: string,
 *   outcomes: {velocity: string[], load: string[]}, range: {velocity: number[], load: number[]},
 *   messages: Object<string, string>, fields: Fields, friction_band: Ends | null,
 *   regions: [string, string]}} Content result of pipeline.figures.page.content
 * @typedef {"velocity" | "load"} AxisName
 */

const POINT_DONE = 1;
const POINT_FAILED = 2;

/** The sweep of a page. */
class Sweep {
  /** @param {Content} content */
  constructor(content) {
    this.content = content;
    this.loads = content.loads;
    /** Number of surfaces; each has a place for every load and velocity. */
    this.surfaces = content.surfaces?.length ?? 1;
    this.status = new Int8Array(bytes(content.status));
    this.asked = new Uint8Array(bytes(content.asked));
    this.times = new Float32Array(bytes(content.times));
    this.rises = new Float32Array(bytes(content.rises));
    const { steps, loads, rises, own } = content.course;
    this.course = {
      steps, loads: new Float32Array(bytes(loads)), rises: new Float32Array(bytes(rises)),
      own: new Uint8Array(bytes(own)),
    };
    /** Relative errors of the rise by surface, on and between the loads, and the velocities. */
    this.errors = new Float32Array(bytes(content.errors));
    this.numbers = content.numbers.map(({ values }) => new Float32Array(bytes(values)));
    /** Lines by share and bulk ratio. @type {Map<string, number[][][]>} */
    this.kept = new Map();
    this.velocities = content.velocities;
    this.fine = content.fine;
    this.range = content.range;
  }

  /** @param {number} surface @param {number} i of the load @param {number} j of the velocity */
  place(surface, i, j) {
    return (surface * this.loads.length + i) * this.velocities.length + j;
  }

  /**
   * Entry of a table by place, bulk ratio and a last axis of which entries are weighed, by straight
   * lines between bulk ratios.
   * @param {Float32Array} table @param {number} width of the last axis @param {Conditions} conditions
   * @returns {(place: number, last: [number, number][]) => number}
   */
  reader(table, width, conditions) {
    const { bulk_ratios: ratios } = this.content;
    const byRatio = weights(ratios, bulkRatio(conditions));
    return (place, last) => {
      let value = 0;
      for (const [b, ofRatio] of byRatio) {
        const begin = (place * ratios.length + b) * width;
        for (const [k, weight] of last) value += ofRatio * weight * table[begin + k];
      }
      return value;
    };
  }

  /**
   * Deciding rises by surface and line: along velocity at the fine loads, or along load at the
   * velocities of the sweep [K].
   * @param {AxisName} axis @param {Conditions} conditions
   */
  lines(axis, conditions) {
    const { shares, lines } = this.content;
    const { failing_share, at_one_friction = false } = conditions;
    const key = `${axis} ${failing_share} ${bulkRatio(conditions)} ${at_one_friction}`;
    const kept = this.kept.get(key);
    if (kept) return kept;
    const read = this.reader(new Float32Array(bytes(lines[axis])), shares.length, conditions);
    const share = weights(shares, failing_share);
    const count = axis === "velocity" ? this.fine.load.length : this.velocities.length;
    const length = this.fine[axis].length;
    const made = Array.from({ length: this.surfaces }, (_, surface) =>
      Array.from({ length: count }, (_line, i) =>
        Array.from({ length }, (_place, j) => {
          const rise = read((surface * count + i) * length + j, share);
          const k = axis === "velocity" ? j : i * this.content.parts.velocity;
          return at_one_friction ? rise / this.content.friction_factors[k] : rise;
        }),
      ),
    );
    if (this.kept.size > 20) this.kept.clear();
    this.kept.set(key, made);
    return made;
  }

  /**
   * Transition along a line of those.
   * @param {AxisName} axis @param {number} surface @param {number} k @param {Conditions} conditions
   */
  transition(axis, surface, k, conditions) {
    const lines = this.lines(axis, conditions);
    const begin = (surface * lines[surface].length + k) * lines[surface][k].length;
    const isBridged = (/** @type {number} */ n) => this.content.bridged[axis][begin + n] === "1";
    return transitionAlong(
      this.fine[axis], lines[surface][k], riseLimit(conditions), this.range[axis], isBridged,
    );
  }

  /** Deciding rise of a point that is done [K].
   * @param {number} surface @param {number} i @param {number} j @param {Conditions} conditions */
  rise(surface, i, j, conditions) {
    const isDone = this.status[this.place(surface, i, j)] === POINT_DONE;
    return isDone ? this.lines("load", conditions)[surface][j][i * this.content.parts.load] : NaN;
  }

  /** Quantiles of the rise at a point [K]. @param {number} place @param {Conditions} conditions */
  quantiles(place, conditions) {
    const { quantiles } = this.content;
    const read = this.reader(this.rises, quantiles.length, conditions);
    return quantiles.map((_, k) => read(place, [[k, 1]]));
  }

  /**
   * Critical velocity by load and critical load by velocity over surfaces.
   * @param {number[]} surfaces @param {Conditions} conditions
   */
  boundary(surfaces, conditions) {
    const over = (/** @type {AxisName} */ axis, /** @type {number} */ k) =>
      summaryOf(surfaces.map((surface) => this.transition(axis, surface, k, conditions)));
    return {
      velocity: this.loads.map((_, i) => over("velocity", i * this.content.parts.load)),
      load: this.velocities.map((_, j) => over("load", j)),
    };
  }

  /**
   * Boundaries to draw: critical velocity at each of the fine loads, infinite beyond the sweep and
   * NaN where not known. Of one surface; or of several the lower edge of the band, the median and
   * the upper edge.
   * @param {number[]} surfaces @param {Conditions} conditions
   */
  drawn(surfaces, conditions) {
    const ends = this.fine.load.map((_, i) =>
      surfaces.map((surface) => this.transition("velocity", surface, i, conditions).ends),
    );
    const shares = surfaces.length > 1 ? BAND : [0.5];
    return shares.map((share) => ends.map((pairs) => quantileOfEnds(pairs, share)));
  }

  /**
   * Rise at any load and velocity [K], and the transitions along both lines through that place.
   * @param {number} surface @param {number} load @param {number} velocity @param {Conditions} conditions
   */
  margin(surface, load, velocity, conditions) {
    const { fine, range } = this;
    const rows = this.lines("velocity", conditions)[surface];
    const row = fine.velocity.map((_, j) => valueAt(fine.load, rows.map((line) => line[j]), load));
    const j = this.velocities.indexOf(velocity);
    const column = rows.map((line) => valueAt(fine.velocity, line, velocity));
    const upwards = j < 0 ? column : this.lines("load", conditions)[surface][j];
    return {
      rise: valueAt(fine.velocity, row, velocity),
      velocity: transitionAlong(fine.velocity, row, riseLimit(conditions), range.velocity),
      load: transitionAlong(fine.load, upwards, riseLimit(conditions), range.load),
    };
  }
}
