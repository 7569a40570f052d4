// Inspector, "Graph": the functions a computed solid is made of, in the way of what flows through them.

import type { App } from '../app';
import { functionDialog } from '../dialogs/functions';
import { copying, type Graph, madeNode, outputs, removal, sentence } from '../graph';
import { labelOf, schemaAt } from '../schema';
import { button, iconButton, row } from '../ui/controls';
import { h, live, type Child } from '../ui/dom';
import { icon } from '../ui/icons';
import { menuButton } from '../ui/floating';
import { badge, listRow, section, setNote } from '../ui/layout';
import type { Context } from './context';
import { inputControl, nodeCard } from './graphnode';
import { NodePictures } from './graphpictures';
import { addNodes, graphOf, withFile } from './graphsteps';

/** What the texture section shows of a computed solid: its name, how much it is made of, and the way to another. */
export function computedCard(context: Context): HTMLElement {
  const host = h('div');
  live(context.app.store, host, ['document', 'body'], (state) => {
    const found = graphOf(state);
    return { name: found?.graph.solid.name as string | undefined, count: found?.graph.nodes.length ?? 0 };
  }, ({ name, count }) => h('button', { type: 'button', class: 'type-card', 'data-key': 'type',
    'data-tip': 'Choose another texture', 'data-tip-keys': context.commands.get('type').keys[0],
    onclick: () => context.chooseType() },
  h('span', { class: 'type-mark computed', 'aria-hidden': 'true' }, icon('noise', 26)),
  h('span', { class: 'list-text' }, h('span', { class: 'list-title' }, name ?? ''),
    h('span', { class: 'list-detail' }, `Computed from ${count} function${count === 1 ? '' : 's'}`)),
  h('span', { class: 'type-change' }, 'Change…')));
  return host;
}

/** The section; it follows the chosen body's solid. */
export function graphSection(context: Context): HTMLElement {
  const { app } = context, part = section('graph', 'Graph'), nodes = h('div'), gives = h('div');
  const pictures = new NodePictures(app);
  part.body.append(nodes, gives);
  let open: string | null = null;
  const toggle = (name: string | null): void => { open = open === name ? null : name; refresh(); };
  const refresh = live(app.store, nodes, ['document', 'body', 'functions'], (state) => {
    const found = graphOf(state);
    return { place: found?.place ?? null, open, rows: found ? rowsOf(found.graph) : [] };
  }, ({ place, rows }) => {
    part.show(place !== null);
    setNote(part, rows.length ? String(rows.length) : null);
    if (!place) return null;
    return [
      h('ul', { class: 'list nodes', 'aria-label': 'Functions, each after those it takes from' },
        rows.map((each) => nodeRow(context, pictures, place, each, open === each.name, toggle, (name) => { open = name; }))),
      h('div', { class: 'actions' }, button('Add a function…', () => addNode(app, (name) => { open = name; }),
        { icon: 'plus', key: 'node+' })),
    ];
  });
  live(app.store, gives, ['document', 'body', 'functions', 'schema'], (state) => {
    const found = graphOf(state);
    return found && { place: found.place, values: outputs.map(({ name }) => found.graph.solid[name]),
      names: found.graph.nodes.map((node) => [node.name, found.graph.gives(node)]) };
  }, (what) => what && outputRows(app, what.place));
  return part.element;
}

interface NodeRow { name: string; word: string; detail: string; index: number; needed: boolean }

/* What rows say of the nodes. */
function rowsOf(graph: Graph): NodeRow[] {
  const needed = graph.needed();
  return graph.order().map((node) => {
    const from = [...new Set(graph.namesIn(node))];
    return { name: node.name, word: labelOf(node.function), index: graph.indexOf(node.name),
      detail: from.length ? `of ${sentence(from)}` : '', needed: needed.has(node.name) };
  });
}

function nodeRow(context: Context, pictures: NodePictures, place: string, own: NodeRow, isOpen: boolean,
  toggle: (name: string) => void, open: (name: string | null) => void): HTMLElement {
  const { app } = context;
  const menu = menuButton(iconButton('more', `Duplicate or remove ${own.name}`, () => {},
    { look: 'plain', key: `node ${own.name} menu` }), () => [
    { label: 'Duplicate', icon: 'plus', run: () => duplicate(app, own.name, open) },
    { label: 'Remove', icon: 'trash', danger: true, run: () => void remove(app, own.name) },
  ]);
  return listRow({
    lead: pictures.canvas(own.name, own.word), text: own.name, detail: [own.word, own.detail && ` ${own.detail}`],
    key: `node ${own.name}`, chosen: isOpen, choose: () => toggle(own.name),
    actions: [!own.needed && badge('Unused', 'plain', 'No output is made of it'), menu],
    more: isOpen && h('div', { class: 'row-more' }, nodeCard(context, `${place}.nodes[${own.index}]`, own.name, open)),
  });
}

/* ---- outputs ------------------------------------------------------------------------------------------------------- */

/* Colour, opacity, displacement: the nodes the solid itself takes. */
function outputRows(app: App, place: string): Child {
  const { state } = app.store, found = graphOf(state);
  if (!found) return null;
  const about = schemaAt(state.schema, state.document, place)?.properties ?? {};
  return [h('div', { class: 'sub-head' }, h('h4', null, 'What the solid is made of')), h('div', { class: 'rows' },
    outputs.map((input) => row(labelOf(input.name), inputControl(app, null, input, found.graph.solid[input.name],
      { path: `${place}.${input.name}`, of: 'the solid', none: input.name === 'opacity' ? 'as the colour says' : 'none' }),
    { tip: about[input.name]?.description })))];
}

/* ---- steps --------------------------------------------------------------------------------------------------------- */

function addNode(app: App, open: (name: string) => void): void {
  functionDialog(app, 'Add a function', null, (from) => withFile(app, from, (file) => {
    const { state } = app.store, found = graphOf(state);
    if (!found) return;
    const { graph, place } = found, name = graph.freshName(from.replaceAll('_', ' '));
    const { node, more } = madeNode(graph, state.functions, state.schema, name, from, {}, file);
    open(name);
    void addNodes(app, `Add ${name}`, [node, ...more].map((value, i) =>
      ({ op: 'set', path: `${place}.nodes[${graph.nodes.length + i}]`, value })), from);
  }));
}

function duplicate(app: App, name: string, open: (name: string) => void): void {
  const found = graphOf(app.store.state);
  if (!found) return;
  const made = copying(found.graph, found.place, name);
  open(made.name);
  void app.actions.apply(`Duplicate ${name}`, made.operations);
}

async function remove(app: App, name: string): Promise<void> {
  const found = graphOf(app.store.state);
  if (!found) return;
  const operations = removal(found.graph, found.place, name);
  if (typeof operations === 'string') app.messages.say(operations, 'warning');
  else await app.actions.apply(`Remove ${name}`, operations);
}
