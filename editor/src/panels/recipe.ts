// Inspector, "Recipe": how the exemplar is made, layer by layer, where the recipe stands in the document.

import { setValue, removeValue, type App } from '../app';
import type { Json } from '../protocol';
import { fieldsAt, labelOf, schemaAt, valueAt } from '../schema';
import { solidOf } from '../store';
import { button, colourField, iconButton, row } from '../ui/controls';
import { h, live, type Child } from '../ui/dom';
import { gradient, type Stop } from '../ui/gradient';
import { icon, type IconName } from '../ui/icons';
import { listRow, section, setNote } from '../ui/layout';
import { numberField, slider } from '../ui/slider';
import type { Context } from './context';
import { exemplarName } from './exemplars';
import { freshEntry, join, optionRows } from './options';

/** The section; it follows the chosen body's solid. */
export function recipeSection(context: Context): HTMLElement {
  const { app } = context, part = section('recipe', 'Recipe', { folded: true });
  live(app.store, part.body, ['document', 'body'], (state) => {
    const solid = solidOf(state);
    const exemplar = solid?.json.kind === 'lapped' ? solid.json.exemplar as Json : null;
    return { place: exemplar && `${solid!.place}.exemplar`, recipe: exemplar?.recipe as string | undefined,
      file: exemplar?.file as string | undefined,
             layered: Boolean(exemplar?.layered) };
  }, ({ place, recipe, file, layered }) => {
    part.show(place !== null);
    setNote(part, recipe ? exemplarName({ recipe }) : null);
    if (!place) return null;
    if (layered) return layeredEditor(context, `${place}.layered`);
    if (file) return h('p', { class: 'quiet' }, 'This exemplar is a file of voxels; only recipes can be changed here.');
    return [h('p', { class: 'quiet' }, 'The recipe is a file of its own, which other documents may use too.'),
            h('div', { class: 'actions' }, button('Edit a copy here', () => void editCopy(app, place, recipe!),
              { icon: 'edit', key: 'edit-copy' }))];
  });
  return part.element;
}

async function editCopy(app: App, place: string, path: string): Promise<void> {
  await app.actions.try(app.connection.ask('recipe', { path }).then(async ({ recipe }) => {
    await setValue(app, 'Edit a copy of the recipe', place, { layered: recipe });
  }));
}

/* Each part of the editor follows its own keys, so that changing one does not build the others anew. */
function layeredEditor(context: Context, place: string): Child {
  const { app } = context;
  return [
    stopsEditor(context, place), layersEditor(context, place, 'noises', 'noise', 'noise', noiseWord),
    layersEditor(context, place, 'particles', 'particles', 'grain', particleWord),
    layersEditor(context, place, 'bricks', 'bricks', 'brick', brickWord),
    sizeRow(app, place), optionRows(app, place, { of: 'recipe', skip: ['strip'], more: ['strip_blend'] }),
  ];
}

/* ---- colours by depth -------------------------------------------------------------------------------------------- */

function stopsEditor({ app }: Context, place: string): HTMLElement {
  const { store } = app, host = h('div', { class: 'stops' }), path = `${place}.stops`;
  let chosen = 0;
  const refresh = live(store, host, ['document'], (state) =>
    ({ stops: (valueAt(state.document, path) ?? []) as Json[], chosen }), ({ stops }) =>
    stopsBody(app, path, stops, Math.min(chosen, stops.length - 1), (next) => { chosen = next; refresh(); }));
  return host;
}

function stopsBody(app: App, path: string, stops: Json[], chosen: number, choose: (index: number) => void): Child {
  const given: Stop[] = stops.map((stop) => ({ at: stop.depth, colour: stop.colour, opacity: stop.opacity ?? 1 }));
  const write = (name: string, next: Stop[]): void => void setValue(app, name, path, next.map((stop) => ({
    depth: stop.at, colour: stop.colour, ...(stop.opacity === 1 ? {} : { opacity: stop.opacity }),
  })));
  const ramp = gradient(given, { range: [0, 1], word: 'depth', chosen, choose, change: (next, what, index) => {
    choose(Math.max(0, Math.min(index, next.length - 1)));
    write(what, next);
  } });
  const one = given[chosen];
  const edit = (name: string, change: Partial<Stop>): void => {
    const changed = { ...one, ...change };
    const next = given.map((stop, i) => (i === chosen ? changed : stop)).sort((a, b) => a.at - b.at);
    choose(next.indexOf(changed));
    write(name, next);
  };
  return [
    h('div', { class: 'sub-head' }, h('h4', null, 'Colours by depth'),
      h('span', { class: 'ends' }, 'outside', h('span', null, 'core'))), ramp,
    stops.length === 0 ? h('p', { class: 'quiet' }, 'Click the bar to add a colour.') : h('div', { class: 'stop-edit' },
      colourField('Colour', one.colour, (colour) => edit('Set colour', { colour }), { key: `${path}.colour` }).element,
      h('span', { class: 'mini-label', 'aria-hidden': 'true' }, 'at'),
      numberField('Depth', { min: 0, max: 1 }, one.at, (at) => edit('Move stop', { at }),
        { key: `${path}.depth` }).element,
      iconButton('trash', 'Remove stop',
        () => { choose(Math.max(0, chosen - 1)); write('Remove stop', given.filter((_, i) => i !== chosen)); },
        { look: 'plain', key: `${path}-` })),
    stops.length > 0 && row('Opacity', slider('Opacity of the stop', { min: 0, max: 1, default: 1 }, one.opacity,
      (opacity) => edit('Set opacity', { opacity }),
      { key: `${path}.opacity` }).element, { tip: '0 is seen through, 1 opaque.' }),
  ];
}

/* ---- noises, particles, bricks ----------------------------------------------------------------------------------- */

function layersEditor({ app }: Context, place: string, key: string, one: string, picture: IconName,
  word: (layer: Json) => Child): HTMLElement {
  const { store } = app, path = join(place, key), host = h('div');
  let open = -1;
  const toggle = (index: number): void => { open = open === index ? -1 : index; refresh(); };
  const refresh = live(store, host, ['document', 'schema'], (state) => {
    const layers = (valueAt(state.document, path) ?? []) as Json[];
    return { colours: layers.map((layer) => [layer.colour, layer.joint_colour, layer.core_colour, layer.warp]),
      count: layers.length, open };
  }, ({ count }) => {
    const layers = (valueAt(store.state.document, path) ?? []) as Json[];
    const rows = layers.map((layer, i) => listRow({
      lead: word(layer), text: `${labelOf(one)} ${i + 1}`, detail: layer.warp ? 'bends what lies under it' : undefined,
      key: `${path}[${i}]`,
      chosen: open === i, choose: () => toggle(i),
      actions: iconButton('trash', `Remove ${one} ${i + 1}`,
        () => { open = -1; void removeValue(app, `Remove ${one}`, `${path}[${i}]`); },
        { look: 'plain', key: `${path}[${i}]-` }),
      more: open === i && h('div', { class: 'row-more' }, layerOptions(app, `${path}[${i}]`, `${one} ${i + 1}`, key)),
    }));
    const add = (): void => {
      const fields = fieldsAt(store.state.schema, store.state.document, `${path}[${count}]`);
      open = count;
      void setValue(app, `Add ${one}`, `${path}[${count}]`, freshEntry(fields, starts[key]));
    };
    return [h('div', { class: 'sub-head' }, h('h4', null, icon(picture, 16), labelOf(key)),
      iconButton('plus', `Add ${one}`, add, { look: 'plain', key: `${path}+` })),
            rows.length > 0 && h('ul', { class: 'list', 'aria-label': labelOf(key) }, rows)];
  });
  return host;
}

/* What a new layer starts with, where the schema gives no default. */
const starts: { [key: string]: Json } = {
  noises: { colour: '#405020', amount: 0.5 }, particles: { colour: '#302010' },
  bricks: { colour: '#a05a3c', joint_colour: '#d8d0c4' },
};

const often: { [key: string]: string[] } = {
  noises: ['colour', 'amount', 'coverage', 'sharpness', 'size_r', 'size_s', 'size_t', 'depth_low', 'depth_high'],
  particles: ['colour', 'core_colour', 'density', 'radius_r', 'radius_s', 'radius_t', 'depth_low', 'depth_high',
    'size_variation'],
  bricks: ['colour', 'joint_colour', 'size_r', 'size_s', 'size_t', 'joint', 'roundness'],
};

const sizes: [number, number] = [0.03, 3];

function layerOptions(app: App, place: string, of: string, key: string): HTMLElement {
  const all = Object.keys(schemaAt(app.store.state.schema, app.store.state.document, place)?.properties ?? {});
  const first = often[key].filter((each) => all.includes(each)), rest = all.filter((each) => !first.includes(each));
  return optionRows(app, place, { of, only: [...first, ...rest], more: rest,
    soft: { size_r: sizes, size_s: sizes, size_t: sizes } });
}

function dot(...colours: (string | undefined)[]): HTMLElement {
  const given = colours.filter((colour) => colour !== undefined);
  return h('span', { class: 'colour-dots', 'aria-hidden': 'true' },
    given.map((colour) => h('span', { class: 'colour-dot', style: `--colour: ${colour}` })));
}

const noiseWord = (layer: Json): Child => dot(layer.warp ? undefined : layer.colour ?? '#000000');
const particleWord = (layer: Json): Child => dot(layer.colour, layer.core_colour);
const brickWord = (layer: Json): Child => dot(layer.colour, layer.joint_colour);

/* ---- size -------------------------------------------------------------------------------------------------------- */

function sizeRow(app: App, place: string): HTMLElement {
  const host = h('div'), path = `${place}.size`, spec = { min: 8, max: 256, whole: true };
  live(app.store, host, ['document'], (state) => (valueAt(state.document, path) ?? [64, 64, 64]) as number[], (size) => {
    const change = (axis: number, value: number): void =>
      void setValue(app, 'Set exemplar size', path, size.map((old, k) => (k === axis ? value : old)));
    const fields = ['r', 's', 't'].map((axis, i) =>
      numberField(`Voxels along ${axis}`, spec, size[i], (value) => change(i, value), { key: `${path}${i}` }).element);
    return row('Voxels', h('div', { class: 'triple' }, fields),
      { tip: 'Voxels along r, s and t. More are finer, and take longer. 8 to 256.' });
  });
  return host;
}
