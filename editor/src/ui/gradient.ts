// A gradient whose stops are dragged, added and taken away; and the same with heights, for transfer functions.

import { h, hold, set, svg } from './dom';
import { write } from './numbers';

export interface Stop { at: number; colour: string; opacity: number }

export interface GradientOptions {
  range: [number, number];
  /** What a stop's place is called: "depth", "value". */
  word: string;
  /** Draws opacities as heights that are dragged too. */
  heights?: boolean;
  chosen: number;
  choose: (index: number) => void;
  /** A drag, an added or a removed stop is finished; stops are in order, `chosen` is where the changed one went. */
  change: (stops: Stop[], what: 'Move stop' | 'Add stop' | 'Remove stop', chosen: number) => void;
}

const tall = 72, flat = 28;

/** Builds the control. A click on it adds a stop there; stops are dragged, arrow keys move them, Delete removes one. */
export function gradient(given: Stop[], options: GradientOptions): HTMLElement {
  const { range: [low, high], heights } = options, span = high - low || 1;
  let stops = given.map((stop) => ({ ...stop }));
  const share = (at: number): number => Math.min(1, Math.max(0, (at - low) / span));
  const ramp = h('div', { class: heights ? 'gradient tall' : 'gradient',
    'data-tip': `Click to add a stop; drag to move one` });
  const bar = h('div', { class: 'gradient-bar' }),
    line = svg('polyline', { class: 'gradient-line', 'vector-effect': 'non-scaling-stroke' });
  ramp.append(bar);
  if (heights) ramp.append(svg('svg', { class: 'gradient-sheet', viewBox: '0 0 1 1', preserveAspectRatio: 'none',
    'aria-hidden': 'true' }, line));
  const handles = stops.map((_, i) => handle(i));
  ramp.append(...handles);

  function paint(): void {
    const ordered = stops.map((stop, i) => ({ ...stop, i })).sort((a, b) => a.at - b.at);
    bar.style.background = ordered.length === 0 ? '' : ordered.length === 1 ? ordered[0].colour
      : `linear-gradient(to right, ${ordered.map((stop) => `${stop.colour} ${100 * share(stop.at)}%`).join(', ')})`;
    line.setAttribute('points', [{ at: low, opacity: ordered[0]?.opacity ?? 0 }, ...ordered,
      { at: high, opacity: ordered.at(-1)?.opacity ?? 0 }]
      .map((stop) => `${share(stop.at)},${1 - stop.opacity}`).join(' '));
    stops.forEach((stop, i) => {
      const { style } = handles[i];
      style.left = `${100 * share(stop.at)}%`;
      if (heights) style.top = `${100 * (1 - stop.opacity)}%`;
      style.setProperty('--colour', stop.colour);
      set(handles[i], 'aria-valuenow', stop.at);
      set(handles[i], 'aria-valuetext',
        `${options.word} ${write(stop.at)}, ${stop.colour}${heights ? `, opacity ${write(stop.opacity)}` : ''}`);
      set(handles[i], 'data-chosen', i === options.chosen);
    });
  }

  function place(event: PointerEvent | MouseEvent): { at: number; opacity: number } {
    const box = ramp.getBoundingClientRect();
    const across = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    const down = Math.min(1, Math.max(0, (event.clientY - box.top) / box.height));
    return { at: Number((low + across * span).toPrecision(3)), opacity: Number((1 - down).toFixed(2)) };
  }

  function finish(what: 'Move stop' | 'Add stop' | 'Remove stop', changed: Stop): void {
    const ordered = stops.slice().sort((a, b) => a.at - b.at);
    options.change(ordered, what, Math.max(0, ordered.indexOf(changed)));
  }

  function handle(index: number): HTMLElement {
    const made = h('span', { class: 'gradient-stop', role: 'slider', tabindex: 0, 'aria-label': `Stop ${index + 1}`,
      'aria-valuemin': low, 'aria-valuemax': high, 'data-key': `stop ${index}` });
    made.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      event.stopPropagation();
      made.focus();
      made.setPointerCapture(event.pointerId);
      hold(made, true);
      let moved = false;
      const from = { x: event.clientX, y: event.clientY };
      const move = (next: PointerEvent): void => {
        if (!moved && Math.hypot(next.clientX - from.x, next.clientY - from.y) < 3) return;
        moved = true;
        const { at, opacity } = place(next);
        stops[index] = { ...stops[index], at, opacity: heights ? opacity : stops[index].opacity };
        paint();
      };
      made.addEventListener('pointermove', move);
      made.addEventListener('lostpointercapture', () => {
        made.removeEventListener('pointermove', move);
        hold(made, false);
        if (moved) finish('Move stop', stops[index]);
        else options.choose(index);
      }, { once: true });
    });
    made.addEventListener('keydown', (event) => keys(event, index));
    made.addEventListener('dblclick', (event) => event.stopPropagation());
    return made;
  }

  function keys(event: KeyboardEvent, index: number): void {
    const step = (event.shiftKey ? 0.1 : 0.01) * span;
    const across = { ArrowLeft: -step, ArrowRight: step }[event.key],
      up = { ArrowUp: 0.05, ArrowDown: -0.05 }[event.key];
    if (event.key === 'Delete' || event.key === 'Backspace') remove(index);
    else if (event.key === 'Enter' || event.key === ' ') options.choose(index);
    else if (across !== undefined) {
      stops[index].at = Number(Math.min(high, Math.max(low, stops[index].at + across)).toPrecision(4));
      finish('Move stop', stops[index]);
    } else if (up !== undefined && heights) {
      stops[index].opacity = Number(Math.min(1, Math.max(0, stops[index].opacity + up)).toFixed(2));
      finish('Move stop', stops[index]);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  function remove(index: number): void {
    const [gone] = stops.splice(index, 1);
    finish('Remove stop', gone);
  }

  ramp.style.height = `${heights ? tall : flat}px`;
  ramp.addEventListener('click', (event) => {
    if ((event.target as Element).closest('.gradient-stop')) return;
    const { at, opacity } = place(event), fresh = { at, colour: colourAt(stops, at), opacity: heights ? opacity : 1 };
    stops = [...stops, fresh];
    finish('Add stop', fresh);
  });
  paint();
  return ramp;
}

/** The colour of a gradient at a place, between its stops. */
export function colourAt(stops: Stop[], at: number): string {
  const ordered = stops.slice().sort((a, b) => a.at - b.at);
  const after = ordered.findIndex((stop) => stop.at >= at);
  if (ordered.length === 0) return '#808080';
  if (after <= 0) return (after < 0 ? ordered[ordered.length - 1] : ordered[0]).colour;
  const [a, b] = [ordered[after - 1], ordered[after]], part = (at - a.at) / (b.at - a.at || 1);
  const parts = [1, 3, 5].map((i) => {
    const from = parseInt(a.colour.slice(i, i + 2), 16), to = parseInt(b.colour.slice(i, i + 2), 16);
    return Math.round(from + part * (to - from)).toString(16).padStart(2, '0');
  });
  return `#${parts.join('')}`;
}
