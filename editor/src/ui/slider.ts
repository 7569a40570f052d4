// A number: a track to drag along and a field to type into. Both tell once, when the hand lets go.

import type { Control } from './controls';
import { h, hold, set } from './dom';
import { arrowStep, read, travel, within, write, type NumberSpec } from './numbers';

export interface SliderOptions {
  key?: string;
  id?: string;                      // of the number's field, for its label
  /** While the hand is still moving. */
  moving?: (value: number) => void;
  /** The value that double-clicking the track brings; without it the spec's default. */
  reset?: () => void;
  /** Leaves the track out. */
  bare?: boolean;
}

const steps = 1000;                 // of the track
const afterKeys = 400;              // ms without a key until keys count as finished
const afterDrag = 220;              // ms after a drag in which a second click may still mean "the default"

/** A slider with a number's field. `finish` is told once per drag, per burst of keys and per number typed. */
export function slider(name: string, spec: NumberSpec, value: number, finish: (value: number) => void,
  options: SliderOptions = {}): Control<number> {
  const way = options.bare ? null : travel(spec);
  let shown = value, told = value;
  const show = (next: number): void => {
    field.set(next);
    follow(next);
  };
  const follow = (next: number): void => {
    shown = next;
    if (!way) return;
    track.value = String(Math.round(way.at(next) * steps));
    track.style.setProperty('--at', String(way.at(next)));
    set(track, 'aria-valuetext', `${write(next)} ${spec.unit ?? ''}`.trim());
  };
  const tell = (): void => { if (shown !== told) finish(told = shown); };
  const field = numberField(name, spec, value, (next) => { show(next); tell(); },
    { ...options, moving: (next) => { follow(next); options.moving?.(next); } });
  const track = h('input', { type: 'range', class: 'track', min: 0, max: steps, step: 1, 'aria-label': name,
    'data-key': options.key && `${options.key}~` });
  if (way) {
    const late = later(() => { hold(track, false); tell(); });
    const input = (next: number): void => { hold(track, true); show(next); options.moving?.(next); };
    track.addEventListener('input', () => input(way.value(Number(track.value) / steps)));
    track.addEventListener('change', () => late.soon(afterDrag));
    track.addEventListener('blur', late.now);
    track.addEventListener('dblclick', () => {
      late.stop();
      hold(track, false);
      if (options.reset) options.reset();
      else if (spec.default !== undefined) { show(spec.default); tell(); }
    });
    track.addEventListener('keydown', (event) => {
      if (event.key === 'Escape' && shown !== told) { late.stop(); hold(track,
        false); show(told); event.stopPropagation(); }
      const jump = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!jump) return;
      event.preventDefault();
      input(stepped(spec, shown, jump * (event.shiftKey ? 10 : 1)));
      late.soon(afterKeys);
    });
  }
  show(value);
  const element = h('div', { class: way ? 'slider' : 'slider bare' }, way && track, field.element);
  return { element, set(next) { told = next; show(next); } };
}

/* The value some arrow steps on; values in between are brought onto the steps. */
function stepped(spec: NumberSpec, value: number, count: number): number {
  const step = arrowStep(spec, value);
  return within(Number(((Math.round(value / step) + count) * step).toPrecision(12)), spec);
}

/* Calls once, some time after the last `soon`. */
function later(call: () => void): { soon(delay: number): void; now(): void; stop(): void } {
  let timer = 0;
  const stop = (): void => { clearTimeout(timer); timer = 0; };
  return {
    soon(delay) { clearTimeout(timer); timer = window.setTimeout(() => { timer = 0; call(); }, delay); },
    now() { if (timer) { stop(); call(); } },
    stop,
  };
}

/** A number's field alone: type, arrow up and down, or drag across it. Double-clicking its unit resets. */
export function numberField(name: string, spec: NumberSpec, value: number, finish: (value: number) => void,
  options: SliderOptions = {}): Control<number> {
  let shown = value, told = value;
  const tell = (): void => { if (shown !== told) finish(told = shown); };
  const late = later(() => { hold(input, false); tell(); });
  const input = h('input', {
    type: 'text', inputmode: spec.min < 0 ? 'text' : 'decimal', class: 'number', id: options.id, autocomplete: 'off',
    'aria-label': options.id ? null : spec.unit ? `${name} (${spec.unit})` : name, 'data-key': options.key,
    role: 'spinbutton', 'aria-valuemin': spec.min, 'aria-valuemax': spec.max,
    onfocus: () => input.select(),
    oninput: () => hold(input, true),
    onblur: () => { take(); late.now(); hold(input, false); },
    onkeydown: (event: KeyboardEvent) => keys(event),
  });
  const show = (next: number): void => {
    shown = next;
    input.value = write(next);
    set(input, 'aria-valuenow', next);
    set(input, 'aria-valuetext', `${write(next)} ${spec.unit ?? ''}`.trim());
  };
  const take = (): void => {
    const typed = read(input.value, spec);
    const changed = typed !== null && typed !== shown && input.value.trim() !== write(shown);
    show(changed ? typed : shown);
    if (changed) tell();
  };
  const keys = (event: KeyboardEvent): void => {
    if (event.key === 'Enter') { hold(input, false); take(); late.now(); input.select(); }
    else if (event.key === 'Escape') { late.stop(); show(told); input.blur(); event.stopPropagation(); }
    else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
      event.preventDefault();
      show(stepped(spec, read(input.value, spec) ?? shown,
        (event.key === 'ArrowUp' ? 1 : -1) * (event.shiftKey ? 10 : 1)));
      hold(input, true);
      options.moving?.(shown);
      late.soon(afterKeys);
    }
  };
  const element = h('span', { class: 'number-box' }, input,
    spec.unit && h('span', { class: 'unit', 'aria-hidden': 'true', ondblclick: options.reset }, spec.unit));
  scrub(input, spec, () => shown, (next) => { show(next); options.moving?.(next); }, tell);
  show(value);
  return { element, set(next) { told = next; show(next); } };
}

/* Dragging across a field that has not got the focus changes its number; a click without a drag edits it. */
function scrub(input: HTMLInputElement, spec: NumberSpec, value: () => number, show: (value: number) => void,
  finish: () => void): void {
  let from: { x: number; value: number; moved: boolean } | null = null;
  input.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || document.activeElement === input || event.pointerType === 'touch') return;
    event.preventDefault();
    from = { x: event.clientX, value: value(), moved: false };
    input.setPointerCapture(event.pointerId);
    hold(input, true);
  });
  input.addEventListener('pointermove', (event) => {
    if (!from) return;
    const across = Math.trunc((event.clientX - from.x) / 3);
    if (across === 0 && !from.moved) return;
    from.moved = true;
    show(stepped(spec, from.value, across * (event.shiftKey ? 10 : 1)));
  });
  const end = (event: PointerEvent): void => {
    if (!from) return;
    const before = from;
    from = null;
    hold(input, false);
    if (!before.moved) input.focus();
    else if (event.type === 'pointercancel') show(before.value);
    else finish();
  };
  input.addEventListener('pointerup', end);
  input.addEventListener('pointercancel', end);
}
