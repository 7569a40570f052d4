// Numbers for people: how they are written, read and laid out along a slider.

export interface NumberSpec {
  min: number;
  max: number;
  whole?: boolean;
  default?: number;
  unit?: string;
  /** The stretch a slider covers, when the limits are far beyond what is used. */
  soft?: [low: number, high: number];
}

/** A number as people write it: four significant digits, no more zeros than needed. */
export function write(value: number): string {
  if (!Number.isFinite(value)) return '';
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value);
  const size = Math.abs(value);
  if (size >= 1e9 || size < 1e-4) return value.toExponential(2).replace(/\.?0+e/, 'e').replace('e+', 'e');
  return String(Number(value.toPrecision(4)));
}

/** The number that a text means, held within the limits; null when it means none. */
export function read(text: string, spec: NumberSpec): number | null {
  const plain = text.trim().replace(',', '.').replace(/\s*(°|px|EV|s|MiB)$/, '');
  const value = plain === '' ? NaN : Number(plain);
  return Number.isFinite(value) ? within(value, spec) : null;
}

/** The nearest allowed number. */
export function within(value: number, spec: NumberSpec): number {
  const held = Math.min(spec.max, Math.max(spec.min, value));
  return spec.whole ? Math.round(held) : held;
}

/** How a slider's travel 0..1 becomes a value and back. */
export interface Travel { at(value: number): number; value(at: number): number }

/** The travel that suits a range: even, by factors where it spans several magnitudes from above 0, or by a power that
    puts the default near the middle. Null where no slider helps: both ends are out of sight. */
export function travel(spec: NumberSpec): Travel | null {
  const [low, high] = spec.soft ?? [spec.min, spec.max];
  const span = high - low;
  if (!spec.soft && (span > 2e6 || (low < 0 && span > 1e4))) return null;
  if (low > 0 && high / low > 100) {
    const factor = Math.log(high / low);
    return {
      at: (value) => clamp01(Math.log(Math.max(value, low) / low) / factor),
      value: (at) => tidy(low * Math.exp(factor * at), spec, low * Math.exp(factor * at) / 100),
    };
  }
  const share = spec.default === undefined ? 0 : (spec.default - low) / span;
  const power = share > 0 && share < 0.05 ? Math.log(share) / Math.log(0.4) : 1;
  return {
    at: (value) => clamp01((value - low) / span) ** (1 / power),
    value: (at) => {
      const value = low + span * at ** power;
      return tidy(value, spec, power === 1 ? span / 200 : Math.max(Math.abs(value - low) / 100, span * 1e-9));
    },
  };
}

function clamp01(value: number): number { return Math.min(1, Math.max(0, value)); }

/* A round number within about a step of the value. */
function tidy(value: number, spec: NumberSpec, step: number): number {
  if (spec.whole) return within(value, spec);
  const grain = 10 ** Math.floor(Math.log10(step));
  return within(Number((Math.round(value / grain) * grain).toPrecision(12)), spec);
}

/** What an arrow key adds to a value: a hundredth of the range, or of the value where the range is out of sight. */
export function arrowStep(spec: NumberSpec, value: number): number {
  if (spec.whole) return 1;
  const [low, high] = spec.soft ?? [spec.min, spec.max];
  const wide = high - low > 1000 || (low > 0 && high / low > 100);
  const step = wide ? Math.max(Math.abs(value), 1e-3) / 20 : (high - low) / 100;
  return 10 ** Math.floor(Math.log10(step) + 1e-9);
}

/** Seconds as people say them. */
export function seconds(value: number): string {
  if (value < 0.0995) return `${Math.round(value * 1000)} ms`;
  return value < 60 ? `${value.toFixed(value < 9.95 ? 1 : 0)} s`
    : `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

/** A count with thin spaces between thousands. */
export function count(value: number): string { return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, '\u2009'); }

/** "1 stroke", "3 strokes". */
export function many(value: number, one: string, more =
  `${one}s`): string { return `${count(value)} ${value === 1 ? one : more}`; }
