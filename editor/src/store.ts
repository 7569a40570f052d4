// What the page knows: what the server said, and what this page alone has chosen (tool, mode, selection). One object of
// plain values; whoever shows something listens to the keys it shows.

import type { BodyState, Functions, Json, JobEvent, TypeNeeds } from './protocol';

export type ToolName = 'select' | 'cut' | 'plane' | 'fill' | 'face' | 'depth' | 'points' | 'direction' | 'scale' | 'paste'
  | 'paint-surface' | 'erase-surface';
export type ViewMode = 'solid' | 'depth' | 'shape' | 'volume' | 'surfaces';

export interface State {
  connection: 'connecting' | 'open' | 'lost' | 'gone' | 'refused';
  version: string;
  path: string;
  file: string;
  socket: number;
  schema: Json;
  types: { [type: string]: TypeNeeds };
  functions: Functions;             // of computed solids
  templates: string[];

  revision: number;
  document: Json;
  name: string;
  undo: string[];
  redo: string[];
  saved: boolean;
  recovered: boolean;
  bodies: BodyState[];
  viewWhy: string | null;           // why what is shown is not what the document says
  automatic: boolean;
  jobs: JobEvent[];                 // under way, or just ended

  tool: ToolName;
  mode: ViewMode;
  body: number;                     // what tools work on
  part: number | null;              // the picked part of the view
  paint: number;                    // depth that is painted
  erase: boolean;                   // does painting take paint away?
  palette: number[];
  crease: number;                   // degrees, of the multi-face fill
  layer: number | null;             // depth of the layer looked at
  isolines: boolean;
  lines: 'none' | 'body' | 'layer' | 'skin' | 'section';
  linesOf: '' | 'primary' | 'secondary' | 'tertiary' | 'vectors';
  apart: number;                    // how far parts are pulled apart for looking, 0..1
  size: number;                     // of the exemplar that scale and paste place, model units; 0: not chosen yet
  pasting: Json | null;             // the exemplar that is pasted, as a document writes it
  selectedSurface: string | null;   // name of the surface, of the body that tools work on, that curves and tools work on
  shownSurfaces: { [name: string]: boolean }; // false: hidden in three dimensions; those not in it are shown
  skin: number;                     // opacity of the body's skin about its surfaces, 0..1
  paintWhat: 'colour' | 'blur';     // of surfaces
  paintColour: string;              // '#rrggbb', as documents write colours
  recentColours: string[];          // those painted last, the newest first
  paintBlur: number;                // model units
  paintRadius: number;              // of the brush, model units; 0: not chosen yet
  paintSide: 'both' | 'front' | 'back';
  paintRepeat: 'once' | 'folds' | 'around';
  eraseSide: 'click' | 'right' | 'left'; // what of a surface goes: what is clicked, or a side of the stroke
  surfacesWhy: string | null;       // why the surfaces shown are not what the document says
  keep: 'both' | 'positive' | 'negative'; // of cuts that are drawn
  separate: boolean;                // the same
  chosenCut: number | null;         // the row that Delete takes away
  pointed: string | null;           // the row of a list under the pointer: 'depth 2', 'direction 0', 'scale 1', 'paste 0'
  sketching: boolean;               // are the panes open?
  tab: 'inside' | 'fields' | 'sketch' | 'cuts' | 'look';
  inspector: boolean;               // is it open?
  clip: boolean;                    // is the clip plane shown?
  theme: 'dark' | 'light';
  hint: string;                     // what the tool says in the status bar
  serial: number;                   // goes up with every packet of the view
}

export const initial: State = {
  connection: 'connecting', version: '', path: '', file: '', socket: 0, schema: {}, types: {}, functions: {}, templates: [],
  revision: 0, document: {}, name: '', undo: [], redo: [], saved: true, recovered: false, bodies: [], viewWhy: null, automatic: true,
  jobs: [],
  tool: 'select', mode: 'solid', body: 0, part: null, paint: 0, erase: false, palette: [0, 0.25, 0.5, 0.75, 1],
  crease: 30, layer: null, isolines: true, lines: 'none', linesOf: '', apart: 0, size: 0, pasting: null,
  selectedSurface: null, shownSurfaces: {}, skin: 0.25, paintWhat: 'colour', paintColour: '#c83c28', recentColours: [],
  paintBlur: 0, paintRadius: 0, paintSide: 'both', paintRepeat: 'once', eraseSide: 'click', surfacesWhy: null, keep: 'positive',
  separate: false, chosenCut: null, pointed: null, sketching: false, tab: 'inside', inspector: true, clip: false, theme: 'dark', hint: '', serial: 0,
};

type Key = keyof State;

export class Store {
  readonly state: State = { ...initial };
  private listeners: { keys: Key[]; call: () => void }[] = [];
  private changed = new Set<Key>();

  /** Calls back, once, after any of these keys has changed; returns the way to stop it. */
  on(keys: Key[], call: () => void): () => void {
    const listener = { keys, call };
    this.listeners.push(listener);
    return () => { this.listeners = this.listeners.filter((other) => other !== listener); };
  }

  /** Sets values; listeners hear of it at once, or `delay` milliseconds later, together with what changes meanwhile. */
  set(values: Partial<State>, delay = 0): void {
    for (const key of Object.keys(values) as Key[]) {
      if (this.state[key] === values[key]) continue;
      (this.state as any)[key] = values[key];
      this.changed.add(key);
    }
    if (this.changed.size === 0) return;
    if (delay > 0) this.timer ||= window.setTimeout(() => this.tell(), delay);
    else if (!this.due) {
      this.due = true;
      queueMicrotask(() => this.tell());
    }
  }

  private due = false;
  private timer = 0;

  private tell(): void {
    const changed = this.changed;
    clearTimeout(this.timer);
    this.timer = 0;
    this.due = false;
    this.changed = new Set();
    for (const { keys, call } of this.listeners.slice()) if (keys.some((key) => changed.has(key))) call();
  }
}

/** The object of the body that tools work on: the document itself, or an entry of its bodies, in full where it is like
    another. */
export function bodyJson(state: State, index = state.body): Json {
  return state.document.bodies ? fullBodies(state.document)[index] ?? {} : state.document;
}

const known = new WeakMap<Json, Json[]>();

/* What is not said anew of a body that is like one before it is as there, in objects key by key. */
function fullBodies(document: Json): Json[] {
  const made: Json[] = known.get(document) ?? [];
  if (!known.has(document)) {
    for (const body of document.bodies as Json[]) made.push(body.like ? putOver(made.find(({ name }) => name === body.like) ?? {}, body) : body);
    known.set(document, made);
  }
  return made;
}

function putOver(object: Json, over: Json): Json {
  const plain = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);
  const made = { ...object };
  for (const [key, value] of Object.entries(over)) made[key] = plain(value) && plain(made[key]) ? putOver(made[key], value) : value;
  return made;
}

/** Where that object stands in the document, as operations write places: '' or 'bodies[2].'. */
export function bodyPlace(state: State, index = state.body): string {
  return state.document.bodies ? `bodies[${index}].` : '';
}

/** The key that names the body in an operation: nothing in documents of one body. */
export function bodyKey(state: State, index = state.body): Json {
  return state.document.bodies ? { body: state.document.bodies[index].name } : {};
}

/** The solid the body is made of, and its place; null when it has none. */
export function solidOf(state: State, index = state.body): { json: Json; place: string } | null {
  const body = bodyJson(state, index);
  const solids = (body.solids ?? []) as Json[];
  if (solids.length === 0) return null;
  const at = Math.max(0, solids.findIndex((solid) => solid.name === body.solid));
  return { json: solids[at], place: `${bodyPlace(state, index)}solids[${at}]` };
}

/** A name that is not taken: the wish, or with a number behind it. */
export function freeName(wish: string, taken: (name: string) => boolean): string {
  const base = wish.replace(/ \d+$/, '');
  let name = wish;
  for (let i = 2; taken(name); ++i) name = `${base} ${i}`;
  return name;
}

/** The surfaces of the body, as the document has them. */
export function surfacesOf(state: State, index = state.body): Json[] { return (bodyJson(state, index).surfaces ?? []) as Json[]; }

/** The body whose surfaces a body has: its own, or those of the one that it is like. */
export function surfaceOwner(state: State, index = state.body): number {
  const bodies = (state.document.bodies ?? []) as Json[], body = bodies[index];
  if (!body?.like || body.surfaces) return index;
  return surfaceOwner(state, bodies.findIndex(({ name }) => name === body.like));
}

/** Where a surface of a body stands in the document. */
export function surfacePath(state: State, at: number, index = state.body): string {
  return `${bodyPlace(state, surfaceOwner(state, index))}surfaces[${at}]`;
}

/** The key that names the body with a body's surfaces in an operation on them. */
export function surfaceKey(state: State, index = state.body): Json { return bodyKey(state, surfaceOwner(state, index)); }

/** The surface that is chosen, and its place in the document; null when there is none. */
export function chosenSurface(state: State): { json: Json; place: string; index: number } | null {
  const index = surfacesOf(state).findIndex((surface) => surface.name === state.selectedSurface);
  return index < 0 ? null : { json: surfacesOf(state)[index], place: surfacePath(state, index), index };
}

/** Is a surface the outside of its body? Then it is the body's skin; hollows that bound it, too, lie within. */
export function boundsBody(state: State, body: number, name: string): boolean {
  const bounds = (bodyJson(state, body).shape?.surfaces ?? []) as string[];
  return bounds[0] === name || surfacesOf(state, body).some((each) => each.name === name && each.kind === 'body');
}

/** Is the body's skin one of its surfaces? */
export function isBounded(state: State, body: number): boolean {
  return surfacesOf(state, body).some(({ name }) => boundsBody(state, body, name));
}
