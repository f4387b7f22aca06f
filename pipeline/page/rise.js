"use strict";
/* The deciding rise of a sweep on the nodes that Python has tabulated. Nothing here knows the page. */

const [POINT_DONE, POINT_FAILED] = [1, 2];
/** States of nodes: between loads, one of whose rows goes on beyond its points; or beyond all. */
const [NODE_COMPUTED, NODE_BETWEEN, NODE_EXTRAPOLATED] = ["1", "3", "4"];

/** The sweep of a page. */
class Sweep {
  /** @param {Content} content */
  constructor(content) {
    const floats = (/** @type {string} */ held) => new Float32Array(bytes(held));
    this.content = content;
    this.loads = content.loads;
    this.velocities = content.velocities;
    /** Nodes of the plane; the outermost of velocity lie far beyond the sweep. */
    this.fine = content.fine;
    /** Number of surfaces; each has a place for every load and velocity. */
    this.surfaces = content.surfaces?.length ?? 1;
    this.status = new Int8Array(bytes(content.status));
    this.asked = new Uint8Array(bytes(content.asked));
    this.times = floats(content.times);
    this.rises = floats(content.rises);
    const { steps, loads, rises, own } = content.course;
    this.course = { steps, loads: floats(loads), rises: floats(rises), own: new Uint8Array(bytes(own)) };
    /** Relative numerical errors of the rise at the nodes. */
    this.errors = floats(content.errors);
    this.tables = { plane: floats(content.plane), columns: floats(content.columns) };
    this.numbers = content.numbers.map(({ values }) => floats(values));
    /** Tables by conditions. @type {Map<string, any>} */
    this.kept = new Map();
  }

  /** @param {number} surface @param {number} i of the load @param {number} j of the velocity */
  place(surface, i, j) {
    return (surface * this.loads.length + i) * this.velocities.length + j;
  }

  /** Node of a velocity of the sweep. @param {number} j */
  node(j) {
    return this.content.first + j * this.content.parts.velocity;
  }

  /** Velocities of the nodes within the sweep. */
  inner() {
    return this.fine.velocity.slice(this.content.first, this.node(this.velocities.length - 1) + 1);
  }

  /** Node nearest to a place. @param {{load: number, velocity: number}} place @returns {[number, number]} */
  nearest({ load, velocity }) {
    return [nearest(this.fine.load, load), this.content.first + nearest(this.inner(), velocity)];
  }

  /** Number of a node. @param {number} surface @param {number} k of the load @param {number} j of the
   * velocity */
  index(surface, k, j) {
    return (surface * this.fine.load.length + k) * this.fine.velocity.length + j;
  }

  /** State of a node. @param {number} surface @param {number} k @param {number} j */
  state(surface, k, j) {
    return this.content.state[this.index(surface, k, j)];
  }

  /** @template Made @param {string} key @param {() => Made} make @returns {Made} */
  keep(key, make) {
    const made = this.kept.get(key) ?? make();
    if (this.kept.size > 200) this.kept.clear();
    this.kept.set(key, made);
    return made;
  }

  /** Entries of a row by bulk ratio and a last axis, and their weights. @param {Conditions} conditions @param
   * {number} width @param {[number, number][]} last */
  picks(conditions, width, last) {
    return weights(this.content.bulk_ratios, bulkRatio(conditions)).flatMap(([b, share]) =>
      last.map(([k, weight]) => [b * width + k, share * weight]));
  }

  /** Deciding rises by surface at the nodes, or along load at the velocities of the sweep [K]. @param
   * {"plane" | "columns"} name @param {Conditions} conditions */
  table(name, conditions) {
    const { shares, bulk_ratios, friction_factors: factors } = this.content;
    const { failing_share, at_one_friction } = conditions;
    const key = `${name} ${failing_share} ${bulkRatio(conditions)} ${at_one_friction}`;
    const [isPlane, table, width] = [name === "plane", this.tables[name], bulk_ratios.length * shares.length];
    const picks = this.picks(conditions, shares.length, weights(shares, failing_share));
    const { load, velocity } = this.fine;
    const [m, n] = isPlane ? [load, velocity] : [this.velocities, load];
    return this.keep(key, () => Array.from({ length: this.surfaces }, (_surface, s) =>
      m.map((_row, i) => n.map((_place, j) => {
        const begin = ((s * m.length + i) * n.length + j) * width;
        const rise = picks.reduce((total, [k, weight]) => total + weight * table[begin + k], 0);
        return at_one_friction ? rise / factors[isPlane ? j : this.node(i)] : rise;
      }))));
  }

  /** The plane of a surface, NaN where it is not known. Between two loads at which wear turns, that may rest
   * on rises that go on beyond the points. @param {number} surface @param {Conditions} conditions */
  known(surface, conditions) {
    const [limit, { velocity }, parts] = [riseLimit(conditions), this.fine, this.content.parts.load];
    return this.keep(`${surface} ${JSON.stringify(conditions)}`, () => {
      const plane = this.table("plane", conditions)[surface].map((row, k) =>
        row.map((rise, j) => (this.state(surface, k, j) === NODE_EXTRAPOLATED ? NaN : rise)));
      const turns = this.loads.map((_, i) => crossings(velocity, plane[i * parts], limit).length > 0);
      return plane.map((row, k) => {
        const isTurning = turns[Math.floor(k / parts)] && turns[Math.ceil(k / parts)];
        return row.map((rise, j) => (isTurning || this.state(surface, k, j) !== NODE_BETWEEN ? rise : NaN));
      });
    });
  }

  /** Transition along velocity at a node of load, or along load at one of velocity. @param {AxisName} axis
   * @param {number} surface @param {number} node @param {Conditions} conditions */
  transition(axis, surface, node, conditions) {
    const [{ first, parts, range }, limit] = [this.content, riseLimit(conditions)];
    const own = (node - first) / parts.velocity;
    const line = axis === "velocity" ? this.known(surface, conditions)[node]
      : Number.isInteger(own) ? this.table("columns", conditions)[surface][own]
      : this.known(surface, conditions).map((row) => row[node]);
    return transitionAlong(this.fine[axis], line, limit, range[axis]);
  }

  /** Deciding rise of a point that is done [K]. @param {number} surface @param {number} i @param {number} j
   * @param {Conditions} conditions */
  rise(surface, i, j, conditions) {
    const isDone = this.status[this.place(surface, i, j)] === POINT_DONE;
    return isDone ? this.table("plane", conditions)[surface][i * this.content.parts.load][this.node(j)] : NaN;
  }

  /** Quantiles of the rise at a point [K]. @param {number} place @param {Conditions} conditions */
  quantiles(place, conditions) {
    const { quantiles: { length }, bulk_ratios } = this.content;
    return this.content.quantiles.map((_, q) =>
      sum(this.picks(conditions, length, [[q, 1]]).map(([k, weight]) =>
        weight * this.rises[place * bulk_ratios.length * length + k])));
  }
}
