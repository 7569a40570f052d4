// The graph of a computed solid: which node stands behind which, what fits where, and the operations that change it so
// that every name still means something. Nothing here knows what a function does: the server says what it gives and takes.

import type { Functions, InputFacts, Json, ValueKind } from './protocol';
import { freeName } from './store';

/** A place where a node's name, or a plain value, stands. node: the index of the user; -1: an output of the solid. */
export interface Use { node: number; key: string; at: number | null; takes: ValueKind | 'any'; wanted: boolean }

/** What the solid itself takes of its nodes. */
export const outputs: readonly InputFacts[] = [
  { name: 'colour', takes: 'colour', wanted: true, many: false, standard: 0 },
  { name: 'opacity', takes: 'number', wanted: false, many: false, standard: 1 },
  { name: 'displacement', takes: 'number', wanted: false, many: false, standard: 0 },
];

/** Is a value the name of a node? Colours begin with #. */
export function isName(value: unknown): value is string { return typeof value === 'string' && !value.startsWith('#'); }

const listOf = (value: unknown): unknown[] => (Array.isArray(value) ? value : value === undefined ? [] : [value]);

export class Graph {
  readonly nodes: Json[];

  constructor(readonly solid: Json, private readonly functions: Functions) {
    this.nodes = (solid.nodes ?? []) as Json[];
  }

  indexOf(name: string): number { return this.nodes.findIndex((node) => node.name === name); }

  inputsOf(node: Json): readonly InputFacts[] { return this.functions[node.function]?.inputs ?? []; }

  /** The nodes whose names a node writes, in the order of its inputs. */
  namesIn(node: Json): string[] {
    return this.inputsOf(node).flatMap((input) => listOf(node[input.name]).filter(isName));
  }

  /** A node and all that stands behind it. */
  behind(name: string, found = new Set<string>()): Set<string> {
    const node = this.nodes[this.indexOf(name)];
    if (!node || found.has(name)) return found;
    found.add(name);
    for (const other of this.namesIn(node)) this.behind(other, found);
    return found;
  }

  /** What an output is made of; nodes beyond are of no effect. */
  needed(): Set<string> {
    const found = new Set<string>();
    for (const { name } of outputs) if (isName(this.solid[name])) this.behind(this.solid[name], found);
    return found;
  }

  /** The nodes in the way of what flows: each after those it takes from, else as they stand. */
  order(): Json[] {
    const done = new Set<string>(), sorted: Json[] = [];
    const visit = (node: Json): void => {
      if (done.has(node.name)) return;
      done.add(node.name);
      for (const name of this.namesIn(node)) {
        const other = this.nodes[this.indexOf(name)];
        if (other) visit(other);
      }
      sorted.push(node);
    };
    this.nodes.forEach(visit);
    return sorted;
  }

  /** What a node gives: some functions give colours when one of their inputs does. */
  gives(node: Json): ValueKind {
    const own = this.functions[node.function]?.gives ?? 'number';
    if (own === 'point') return own;
    const values = this.inputsOf(node).filter((input) => input.takes === 'any').flatMap((input) => listOf(node[input.name]));
    return values.some((value) => this.valueGives(value) === 'colour') ? 'colour' : own;
  }

  /** The same of a name or a plain value. */
  valueGives(value: unknown): ValueKind {
    if (typeof value === 'number') return 'number';
    const node = isName(value) ? this.nodes[this.indexOf(value)] : undefined;
    return node ? this.gives(node) : 'colour';
  }

  /** Every place that a name, or plain value, stands at. */
  uses(name: string): Use[] {
    const found: Use[] = [];
    const look = (holder: Json, inputs: readonly InputFacts[], node: number): void => {
      for (const { name: key, takes, wanted } of inputs) {
        const value = holder[key];
        if (Array.isArray(value)) value.forEach((each, at) => { if (each === name) found.push({ node, key, at, takes, wanted }); });
        else if (value === name) found.push({ node, key, at: null, takes, wanted });
      }
    };
    this.nodes.forEach((node, i) => look(node, this.inputsOf(node), i));
    look(this.solid, outputs, -1);
    return found;
  }

  /** The nodes that may stand in an input of a node (null: of the solid): of the right kind, and not made of it. */
  fitting(node: Json | null, takes: ValueKind | 'any'): Json[] {
    return this.order().filter((other) => fits(this.gives(other), takes)
      && (node === null || !this.behind(other.name).has(node.name)));
  }

  /** A name that no node has yet. */
  freshName(wish: string): string {
    return freeName(wish, (name) => this.indexOf(name) >= 0);
  }
}

/** May a value of one kind stand where another is taken? Numbers are greys. */
export function fits(gives: ValueKind, takes: ValueKind | 'any'): boolean {
  if (takes === 'any') return gives !== 'point';
  return gives === takes || (takes === 'colour' && gives === 'number');
}

/** The path of a place where a name stands. */
export function pathOf(place: string, use: Use): string {
  const holder = use.node < 0 ? place : `${place}.nodes[${use.node}]`;
  return `${holder}.${use.key}${use.at === null ? '' : `[${use.at}]`}`;
}

/* ---- changes: each gives the operations of one step ---------------------------------------------------------------- */

/** Another name, there and wherever it is used. */
export function renaming(graph: Graph, place: string, name: string, next: string): Json[] {
  return [{ op: 'set', path: `${place}.nodes[${graph.indexOf(name)}].name`, value: next },
    ...graph.uses(name).map((use) => ({ op: 'set', path: pathOf(place, use), value: next }))];
}

/** Takes a node away. What used it takes the node's first input instead; where that does not fit it cannot go, and a
    sentence says why. */
export function removal(graph: Graph, place: string, name: string): Json[] | string {
  const index = graph.indexOf(name), node = graph.nodes[index], uses = graph.uses(name);
  const gone = { op: 'remove', path: `${place}.nodes[${index}]` };
  if (uses.length === 0) return [gone];
  const first = graph.inputsOf(node)[0], value = first && listOf(node[first.name])[0];
  const plainPoint = first?.takes === 'point' && !first.wanted && value === undefined;
  const stands = (use: Use): boolean => (plainPoint ? use.takes === 'point' && !use.wanted
    : value !== undefined && fits(graph.valueGives(value), use.takes));
  const stuck = uses.find((use) => !stands(use));
  if (stuck) {
    const users = [...new Set(uses.filter((use) => !stands(use))
      .map((use) => (use.node < 0 ? `the solid’s ${use.key}` : `“${graph.nodes[use.node].name}”`)))];
    return `“${name}” is used by ${sentence(users)}, and nothing behind it could take its place there.`;
  }
  return [...uses.map((use) => (plainPoint ? { op: 'remove', path: pathOf(place, use) }
    : { op: 'set', path: pathOf(place, use), value })), gone];
}

/** A copy of a node under another name, behind all others. */
export function copying(graph: Graph, place: string, name: string): { operations: Json[]; name: string } {
  const fresh = graph.freshName(/ \d+$/.test(name) ? name : `${name} 2`);
  const value = { ...structuredClone(graph.nodes[graph.indexOf(name)]), name: fresh };
  return { operations: [{ op: 'set', path: `${place}.nodes[${graph.nodes.length}]`, value }], name: fresh };
}

/* ---- functions ----------------------------------------------------------------------------------------------------- */

/** The schema of the nodes of a function. */
export function functionSchema(schema: Json, name: string): Json { return schema.$defs?.[`function_${name}`] ?? {}; }

/* What keys that hold more than a number start with. */
const starts: { [key: string]: unknown } = {
  stops: [{ at: 0, colour: '#202020' }, { at: 1, colour: '#f0f0f0' }],
  matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]],
  waves: [{ frequency: [1, 0, 0] }],
};

/** The kind of file that nodes of a function must have; null: none. */
export function wantedFile(schema: Json, name: string): 'image' | 'grid' | null {
  const required = (functionSchema(schema, name).required ?? []) as string[];
  return required.includes('image') ? 'image' : required.includes('grid') ? 'grid' : null;
}

/** A node of a function. It keeps what `old` has that the function has too; what the function must have and nothing
    gives, it takes from the nodes there are, or a plain value. `more`: nodes that had to be added for it. */
export function madeNode(graph: Graph, functions: Functions, schema: Json, name: string, from: string, old: Json,
  file: string | null): { node: Json; more: Json[] } {
  const facts = functions[from], own = functionSchema(schema, from), node: Json = { name, function: from }, more: Json[] = [];
  const replaced = graph.nodes[graph.indexOf(name)] ?? null;
  const loose = facts.inputs.length > 0 ? graph.namesIn(old) : [];
  for (const input of facts.inputs) {
    const kept = listOf(old[input.name]).filter((value) => fits(graph.valueGives(value), input.takes));
    let values = kept.length > 0 ? kept : [];
    if (values.length === 0 && input.wanted) {
      const taken = loose.find((other) => fits(graph.valueGives(other), input.takes));
      values = [taken ?? startValue(graph, input, replaced, more)];
    }
    if (values.length > 0) node[input.name] = input.many ? values : values[0];
  }
  for (const [key, schemaOf] of Object.entries((own.properties ?? {}) as Json)) {
    if (key in node || facts.inputs.some((input) => input.name === key)) continue;
    if (key === wantedFile(schema, from)) node[key] = old[key] ?? file;
    else if (key in old && allowed(schemaOf, old[key])) node[key] = old[key];
    else if (((own.required ?? []) as string[]).includes(key)) node[key] = starts[key];
  }
  return { node, more };
}

/* Something for an input that must have something: points come from a node of their own. */
function startValue(graph: Graph, input: InputFacts, node: Json | null, more: Json[]): unknown {
  if (input.takes === 'colour') return '#808080';
  if (input.takes !== 'point') return 0.5;
  const there = graph.fitting(node, 'point').at(-1);
  if (there) return there.name;
  const name = graph.freshName('position');
  if (!more.some((each) => each.name === name)) more.push({ name, function: 'position' });
  return name;
}

function allowed(schema: Json, value: unknown): boolean {
  if (schema.enum) return (schema.enum as unknown[]).includes(value);
  if (typeof value === 'number') return value >= (schema.minimum ?? -Infinity) && value <= (schema.maximum ?? Infinity);
  return true;
}

/** Why a node cannot become one of another function: a sentence; null when it can. */
export function obstacle(graph: Graph, functions: Functions, node: Json, from: string): string | null {
  const gives = functions[from].gives;
  for (const use of graph.uses(node.name)) {
    // Functions that take anything give colours when they get some, so only points are out of place.
    const fit = fits(gives, use.takes) || (gives === 'number' && use.takes === 'colour');
    if (fit) continue;
    const user = use.node < 0 ? `the solid’s ${use.key}` : `“${graph.nodes[use.node].name}”`;
    return `It gives a ${gives}, and ${user} takes ${use.takes === 'any' ? 'numbers or colours' : `a ${use.takes}`}.`;
  }
  return null;
}

/** "a", "a and b", "a, b and c". */
export function sentence(all: string[]): string {
  return all.length < 2 ? all.join('') : `${all.slice(0, -1).join(', ')} and ${all.at(-1)}`;
}

/* ---- whole graphs -------------------------------------------------------------------------------------------------- */

/** A graph that was made for a body of one size, for one of another, somewhere else: everything that looked at the point
    asked for looks at it through a new first node. */
export function placed(solid: Json, functions: Functions, scale: number, middle: [number, number, number]): Json {
  const graph = new Graph(solid, functions), name = graph.freshName('size');
  const round = (value: number): number => Number(value.toPrecision(4));
  const first: Json = { name, function: 'place' };
  ['x', 'y', 'z'].forEach((axis, k) => {
    if (round(middle[k]) !== 0) first[`move_${axis}`] = round(middle[k]);
    first[`scale_${axis}`] = round(scale);
  });
  const nodes = graph.nodes.map((node) => {
    const made = structuredClone(node);
    for (const input of graph.inputsOf(node)) {
      if (input.takes === 'point' && !input.wanted && made[input.name] === undefined) made[input.name] = name;
    }
    return made;
  });
  return { ...structuredClone(solid), nodes: [first, ...nodes] };
}
