// What Python hands to the scripts of a page, and what they hand to each other.

/** Temperatures in kelvin; that of the disk's bulk only where it may differ from the pin's. */
type Conditions = {
  friction: number;
  bulk_temperature: number;
  disk_temperature?: number;
  critical_temperature: number | null;
  failing_share: number;
  /** As a part of the rise by friction. */
  unmodelled_rise: number;
  criterion?: string;
  /** Measured at a place, and does not follow the scene's over velocity. */
  strip_friction?: boolean;
};

type ControlName =
  | "friction"
  | "bulk_temperature"
  | "disk_temperature"
  | "critical_temperature"
  | "failing_share";

type Control = {
  name: ControlName;
  factor: number;
  offset: number;
  least: number | null;
  most: number | null;
  fault: string;
};

type Measurement = {
  load: number;
  velocity: number;
  friction: number | null;
  bulk_temperature?: number;
  outcome?: "mild" | "severe";
  /** Its sign in the legend. */
  sign: string;
  /** That several tests share. */
  run?: string;
  /** Conditions that it is judged at, in place of the reader's. */
  own: Partial<Conditions>;
  node: [number, number];
  isInside: boolean;
  isDrawn: boolean;
};

/** Highest pressure, lowest and highest rise, greatest depth, and the three pictures. */
type Packed = [number, number, number, number, string, string, string];
type Fields = {
  points: { [place: string]: Packed };
  stored: number;
  scales: string[];
  note: string;
  aspect: number;
};

type AxisName = "velocity" | "load";
/** Least and greatest place that a transition may have. */
type Ends = [number, number];

/** Result of pipeline.page.content.content. */
type Content = {
  name: string;
  conditions: Conditions;
  controls: Control[];
  measured: Measurement[];
  loads: number[];
  velocities: number[];
  fine: { velocity: number[]; load: number[] };
  first: number;
  /** Velocities of the nodes within the sweep. */
  inner: number[];
  /** Nodes of the velocities and loads of the sweep, and of the two loads beside each node of load. */
  nodes: { velocity: number[]; load: number[] };
  beside: [number, number][];
  friction_factors: number[];
  /** Temperatures of the contact [K], and the factor of friction at each. */
  plane: Float32Array;
  /** Where lines along velocity begin that have their own points alone, by surface and node of load. */
  lines: { [place: string]: number };
  /** The same of lines along load, by surface and node of velocity. */
  columns: { [place: string]: number };
  state: string;
  errors: Float32Array;
  missing: number[];
  model: Model;
  misfit: string;
  decided: number[];
  quantiles: number[];
  bulk_ratios: number[];
  shares: number[];
  surfaces: number[] | null;
  status: string;
  asked: string;
  outside: string;
  origins: string[];
  times: Float32Array;
  rises: Float32Array;
  numbers: { label: string; unit: string; values: Float32Array }[];
  deciding: string;
  outcomes: { velocity: string[]; load: string[] };
  codes: Record<string, number>;
  range: { velocity: Ends; load: Ends };
  messages: { [place: string]: string };
  fields: Fields;
  friction_band: Ends | null;
};

/**
 * Distribution of the model's own error by the number of transitions: cumulative probability at distances
 * in units of its scale; the prior and the tests that it is worth; words by the number of tests that count.
 */
type Model = {
  distances: number[];
  below: number[][];
  prior: number;
  worth: number;
  words: string[];
  agreed: string;
};

/** Result of pipeline.page.content.content_of_samples, by load and velocity or probability. */
type Samples = {
  outside: string;
  misfit: [string, string][];
  name: string;
  measured: Measurement[];
  loads: number[];
  velocities: number[];
  probability: Float32Array;
  picture: string;
  shares: number[];
};

/** Ranges of severe wear, and the places at which wear turns. */
type Transition = {
  severe: Ends[];
  places: number[];
  outcome: number;
  computed: Ends;
};

/** Quantiles over several surfaces; of one, the first place at which wear turns severe. */
type Summary = { low: number; middle: number; high: number; transitions: Transition[] };

/** Indices of a point in loads and velocities. */
type Point = { i: number; j: number };
type Axes = { loads: number[]; velocities: number[] };
type Attributes = { [name: string]: string | number };
type Place = { load: number; velocity: number };

/** Places of values [px], and values at places. */
type Frame = {
  x: (value: number) => number;
  y: (value: number) => number;
  left: number;
  right: number;
  top: number;
  bottom: number;
  velocity: (across: number) => number;
  load: (down: number) => number;
};
type Axis = { low: number; high: number; label: string };
