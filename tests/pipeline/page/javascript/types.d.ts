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
  | "critical_temperature";

type Control = {
  name: ControlName;
  offset: number;
  least: number | null;
  most: number | null;
  fault: string;
};

type Measurement = {
  load: number;
  velocity: number;
  /** None at a transition. */
  outcome: "mild" | "severe" | null;
  /** One place, or both ends of a transition with a step, each a load and a velocity. */
  places: [number, number][];
  /** Null where the test has no conditions. */
  friction: number;
  bulks: [number, number];
  isAlike: boolean;
  /** Its sign in the legend. */
  sign: string;
  isDrawn: boolean;
};

/** Highest pressure, lowest and highest rise, greatest depth, and the three pictures. */
type Packed = [number, number, number, number, string, string, string];
type Fields = {
  points: { [place: string]: Packed };
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
  /** Nodes of the velocities and loads of the sweep. */
  nodes: { velocity: number[]; load: number[] };
  friction_factors: number[];
  /** ln(rise per unit friction) by bulk ratio, load and velocity. */
  plane: Float32Array;
  /** ln(1 + numerical error) by load and velocity. */
  errors: Float32Array;
  /** The part of the error by the surface, likewise. */
  surface_errors: Float32Array;
  state: string;
  film: string;
  /** Values of ln(limit), and the first place at which the rise passes each, with the outcome's code. */
  targets: number[];
  turns: Record<AxisName, { places: Float32Array; codes: string }>;
  /** Critical temperatures and values of y of the tables of probabilities of severe wear. */
  criticals: number[];
  ys: number[];
  likely: Float32Array;
  /** Loads and velocities of these tables. */
  supports: { load: number[]; velocity: number[] };
  /** y at which severe wear is 5, 50 and 95 % likely, by critical temperature and support. */
  levels: [number, number, number][];
  no_mild: boolean[];
  no_severe: boolean[];
  decided: number[];
  quantiles: number[];
  bulk_ratios: number[];
  status: string;
  asked: string;
  outside: string;
  origins: string[];
  times: Float32Array;
  rises: Float32Array;
  numbers: { label: string; unit: string; values: Float32Array }[];
  deciding: string;
  outcomes: { velocity: string[]; load: string[] };
  several: number;
  messages: { [place: string]: string };
  fields: Fields;
  friction_band: Ends | null;
};

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
type Extent = { low: number; high: number; isLog?: boolean };
type Axis = Extent & { label: string };
type Zoomed = { low?: number; high?: number };
type View = { isLog: boolean; x: Zoomed; y: Zoomed };
