// One function of a graph: its name, what it takes from others, and its options, as the schema tells of them.

import { removeValue, setValue, type App } from '../app';
import { functionDialog } from '../dialogs/functions';
import { functionSchema, isName, madeNode, renaming } from '../graph';
import type { InputFacts, Json } from '../protocol';
import { labelOf, valueAt } from '../schema';
import { button, colourField, iconButton, row, textField } from '../ui/controls';
import { h, live, uid, type Child } from '../ui/dom';
import { icon } from '../ui/icons';
import { numberField } from '../ui/slider';
import { write } from '../ui/numbers';
import type { Context } from './context';
import { fileRow, matrixRows, stopsEditor, wavesEditor } from './graphassets';
import { addNodes, graphOf, withFile } from './graphsteps';
import { optionRows } from './options';

const anyNumber = { min: -1e9, max: 1e9, soft: [-2, 2] as [number, number] };

/** The card of a node. `open` is told its name when that changes. */
export function nodeCard(context: Context, place: string, name: string, open: (name: string) => void): Child {
  const { app } = context, { state } = app.store;
  const node = (valueAt(state.document, place) ?? {}) as Json, own = functionSchema(state.schema, node.function);
  const properties = (own.properties ?? {}) as Json, inputs = h('div', { class: 'rows' });
  live(app.store, inputs, ['document', 'functions'], (now) => {
    const graph = graphOf(app.store.state)?.graph, value = valueAt(now.document, place) as Json | undefined;
    const facts = now.functions[value?.function]?.inputs ?? [];
    return { value: facts.map((input) => value?.[input.name]), function: value?.function as string,
      nodes: graph?.nodes.map((each) => [each.name, graph.gives(each), graph.namesIn(each)]) };
  }, (what) => {
    const now = valueAt(app.store.state.document, place) as Json | undefined;
    return now?.name === name && what.function === node.function ? inputRows(app, place, now, properties) : null;
  });
  const assets = ['stops', 'waves', 'matrix', 'image', 'grid'].filter((key) => key in properties);
  const ranges = softRanges(properties, app.model.diagonal());
  const period = Object.keys(properties).filter((key) => /^period_/.test(key));
  return [
    nameRow(app, place, name, open), functionRow(app, name, node.function, own.description ?? ''), inputs,
    assets.map((key) => assetEditor(app, key, `${place}.${key}`, name, properties[key],
      ((own.required ?? []) as string[]).includes(key))),
    optionRows(app, place, { of: name, skip: ['name', 'function', 'image', 'grid'], soft: ranges, more: period }),
  ];
}

/* ---- name and function --------------------------------------------------------------------------------------------- */

function nameRow(app: App, place: string, name: string, open: (name: string) => void): HTMLElement {
  const id = uid();
  const field = textField('Name', name, (typed) => {
    const found = graphOf(app.store.state), graph = found?.graph, next = typed.trim();
    const taken = graph && graph.indexOf(next) >= 0;
    if (!graph || next === name || next === '' || taken || next.startsWith('#')) {
      field.set(name);
      if (taken && next !== name) app.messages.say(`Another function is called “${next}” already.`, 'warning');
      else if (next.startsWith('#')) app.messages.say('A name cannot begin with #; colours do.', 'warning');
      return;
    }
    open(next);
    void app.actions.apply(`Rename ${name}`, renaming(graph, found!.place, name, next))
      .then((done) => { if (!done) { open(name); field.set(name); } });
  }, { key: `${place}.name`, id });
  return row('Name', field.element, { for: id, tip: 'What other functions call it.' });
}

function functionRow(app: App, name: string, from: string, about: string): Child {
  const change = (): void => functionDialog(app, `What “${name}” computes`, name, (next) => {
    if (next !== from) withFile(app, next, (file) => void changeFunction(app, name, next, file));
  });
  return [row('Function', button([labelOf(from), icon('down', 14)], change,
    { key: 'function', class: 'function-button', tip: 'Choose another function; what both have stays' })),
  h('p', { class: 'quiet node-about' }, about.replace(/`([^`]*)`/g, '“$1”'))];
}

async function changeFunction(app: App, name: string, next: string, file: string | null): Promise<void> {
  const { state } = app.store, found = graphOf(state);
  if (!found) return;
  const { graph, place } = found;
  const index = graph.indexOf(name);
  const { node, more } = madeNode(graph, state.functions, state.schema, name, next, graph.nodes[index], file);
  await addNodes(app, `Make ${name} ${labelOf(next).toLowerCase()}`, [
    { op: 'set', path: `${place}.nodes[${index}]`, value: node },
    ...more.map((value, i) => ({ op: 'set', path: `${place}.nodes[${graph.nodes.length + i}]`, value })),
  ], next);
}

/* ---- inputs -------------------------------------------------------------------------------------------------------- */

function inputRows(app: App, place: string, node: Json, properties: Json): Child {
  return (app.store.state.functions[node.function]?.inputs ?? []).map((input) => {
    const path = `${place}.${input.name}`, tip = properties[input.name]?.description as string | undefined;
    if (input.many) return operandRows(app, place, node, input, tip);
    return row(labelOf(input.name), inputControl(app, node, input, node[input.name], { path, of: node.name }), { tip });
  });
}

interface InputLook { path: string; of: string; none?: string; write?: (value: unknown) => Promise<boolean>; label?: string }

/** What may stand in an input: nothing, a node that fits, a number or a colour. node: whose input; null: the solid's. */
export function inputControl(app: App, node: Json | null, input: InputFacts, value: unknown,
  look: InputLook): HTMLElement {
  const graph = graphOf(app.store.state)!.graph, nodes = graph.fitting(node, input.takes), label = look.label ?? labelOf(input.name);
  const step = `Set ${label.toLowerCase()} of ${look.of}`;
  const put = look.write ?? ((next: unknown) => (next === undefined ? removeValue(app, step, look.path)
    : setValue(app, step, look.path, next)));
  const now = isName(value) ? `node ${value}` : value === undefined ? '' : typeof value === 'number' ? '#number' : '#colour';
  const known = !isName(value) || nodes.some((each) => each.name === value);
  const select = h('select', { class: 'field', 'aria-label': label, 'data-key': look.path },
    !input.wanted && h('option', { value: '' }, look.none ?? standardWord(input)),
    input.takes !== 'point' && h('option', { value: '#number' }, 'a number'),
    (input.takes === 'colour' || input.takes === 'any') && h('option', { value: '#colour' }, 'a colour'),
    nodes.length > 0 && h('optgroup', { label: 'Functions' }, nodes.map((each) =>
      h('option', { value: `node ${each.name}` }, each.name))),
    !known && h('option', { value: now }, String(value)));
  select.value = now;
  select.addEventListener('change', () => {
    const { value: chosen } = select;
    const next = chosen === '' ? undefined : chosen === '#number' ? (typeof value === 'number' ? value : input.standard)
      : chosen === '#colour' ? '#808080' : chosen.slice('node '.length);
    void put(next).then((done) => { if (!done) select.value = now; });
  });
  const field = typeof value === 'number'
    ? numberField(label, anyNumber, value, (next) => void put(next), { key: `${look.path}#` }).element
    : value !== undefined && !isName(value)
      ? colourField(label, value as string, (next) => void put(next), { key: `${look.path}#` }).element : null;
  return h('div', { class: 'node-input' }, h('span', { class: 'select' }, select, icon('down', 14)), field);
}

function standardWord(input: InputFacts): string {
  return input.takes === 'point' ? 'the point asked for' : write(input.standard);
}

/* An input that takes many: each in its place, with ways up, down and out. */
function operandRows(app: App, place: string, node: Json, input: InputFacts, tip: string | undefined): Child {
  const path = `${place}.${input.name}`, given = node[input.name];
  const list = (Array.isArray(given) ? given : given === undefined ? [] : [given]) as unknown[];
  const put = (step: string, next: unknown[]): Promise<boolean> => setValue(app, step, path, next);
  const swap = (a: number, b: number): void => {
    const next = list.slice();
    [next[a], next[b]] = [next[b], next[a]];
    void put(`Move operand of ${node.name}`, next);
  };
  const add = (): void => {
    const nodes = graphOf(app.store.state)!.graph.fitting(node, input.takes);
    const fresh = nodes.filter((each) => !list.includes(each.name)).at(-1)?.name ?? input.standard;
    void put(`Add operand to ${node.name}`, [...list, fresh]);
  };
  const one = { ...input, wanted: true };
  return [h('div', { class: 'sub-head' }, h('h4', { 'data-tip': tip }, 'Operands'),
    iconButton('plus', 'Add operand', add, { look: 'plain', key: `${path}+` })),
  h('ol', { class: 'operands' }, list.map((value, i) => h('li', null,
    inputControl(app, node, one, value, { path: `${path}[${i}]`, of: node.name, label: `Operand ${i + 1}`,
      write: (next) => put(`Set operand ${i + 1} of ${node.name}`, list.map((old, k) => (k === i ? next : old))) }),
    h('span', { class: 'operand-actions' },
      iconButton('up', `Move operand ${i + 1} up`, () => swap(i, i - 1), { look: 'plain', key: `${path}[${i}]^`, disabled: i === 0 }),
      iconButton('down', `Move operand ${i + 1} down`, () => swap(i, i + 1), { look: 'plain', key: `${path}[${i}]v`, disabled: i === list.length - 1 }),
      iconButton('trash', `Remove operand ${i + 1}`, () => void put(`Remove operand of ${node.name}`, list.filter((_, k) => k !== i)),
        { look: 'plain', key: `${path}[${i}]-`, disabled: list.length === 1 })))))];
}

/* ---- what is more than a number ------------------------------------------------------------------------------------ */

function assetEditor(app: App, key: string, path: string, name: string, schema: Json, wanted: boolean): Child {
  if (key === 'stops') return stopsEditor(app, path, name);
  if (key === 'waves') return wavesEditor(app, path, name);
  if (key === 'matrix') return matrixRows(app, path, name);
  return fileRow(app, key as 'image' | 'grid', path, name, schema.description ?? '', wanted);
}

/* The stretch of sliders whose limits are far beyond what is used: lengths go by the size of the model. */
export function softRanges(properties: Json, diagonal: number): { [key: string]: [number, number] } {
  const ranges: { [key: string]: [number, number] } = {}, size = Number(diagonal.toPrecision(1));
  for (const [key, { minimum: low, maximum: high, default: standard, description = '', type }] of Object.entries(properties)) {
    if ((type !== 'number' && type !== 'integer') || high > 1e12 || (high - low <= 1000 && !(low > 0 && high <= 1))) continue;
    if (high <= 1 && low > 0) { ranges[key] = [0, high]; continue; }
    const unit = /\(([^()]*)\)$/.exec(description)?.[1] ?? '';
    if (/^model unit/.test(unit)) ranges[key] = low < 0 ? [-size, size] : low > 0 ? [size / 1000, size] : [0, size];
    else if (/per model unit/.test(unit)) ranges[key] = [1 / size, 200 / size];
    else if (/^degree/.test(unit)) ranges[key] = [-180, 180];
    else if (low < 0) ranges[key] = [-2, 2];
    else if (low > 0 && type === 'number') ranges[key] = [0.01, 100];
    else if (low === 0) ranges[key] = [0, Math.max(4, 4 * (standard ?? 1))];
  }
  return ranges;
}
