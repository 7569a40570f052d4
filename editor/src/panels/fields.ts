// Inspector, "Fields": depth, directions, vectors and size; what of it the chosen type follows comes first.

import { operate, removeValue, setValue } from '../app';
import type { Json, Point } from '../protocol';
import { bodyJson, bodyPlace, solidOf, type State } from '../store';
import { button, checkbox, choice, iconButton, row, segmented } from '../ui/controls';
import { h, live, type Child } from '../ui/dom';
import type { IconName } from '../ui/icons';
import { badge, empty, list, listRow, section, setNote, type Section } from '../ui/layout';
import { many, write } from '../ui/numbers';
import { numberField } from '../ui/slider';
import { paletteCss } from '../view/looks';
import { keyOf, pointAt, type Context } from './context';
import { optionRows } from './options';
import { layerSlider } from './tooloptions';

type Need = 'depth' | 'direction' | 'vectors' | 'scale';

/** The sections of the tab. */
export function fieldsPanel(context: Context): HTMLElement {
  return h('div', { class: 'panel' }, nothingNeeded(context), depthSection(context), directionSection(context),
    vectorsSection(context),
    scaleSection(context), linesSection(context));
}

/* Does the chosen body's type follow a field? */
function needed(state: State, need: Need): boolean {
  const solid = solidOf(state)?.json;
  return solid?.kind === 'lapped' && (state.types[solid.type ?? '1-B']?.[need] ?? false);
}

/* A section is there when its field is followed or given; what is given and not followed says so. */
function mark(part: Section, state: State, need: Need, count: number): void {
  const follows = needed(state, need);
  part.show(follows || count > 0 || (need === 'depth' && !solidOf(state)));
  setNote(part, count > 0 && !follows && solidOf(state)
    ? badge('not used', 'plain', `Type ${solidOf(state)!.json.type ?? '1-B'} does not follow it.`)
    : follows && count === 0 ? badge('needed', 'bad') : count > 0 ? String(count) : null);
}

function nothingNeeded({ app }: Context): HTMLElement {
  const host = h('div');
  live(app.store, host, ['document', 'body', 'types'], (state) => {
    const solid = solidOf(state)?.json;
    return !solid ? 'This body is made of nothing yet; the texture type decides which fields it follows.'
      : solid.kind === 'diffusion' ? 'Colours that flow between surfaces follow no fields.'
        : solid.kind !== 'lapped' ? 'A voxel grid follows no fields.' : null;
  }, (text) => text && empty(text));
  return host;
}

/* ---- depth ------------------------------------------------------------------------------------------------------- */

function depthSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('depth', 'Depth');
  const rows = h('div'), options = h('div');
  part.body.append(rows, options);
  live(store, rows, ['document', 'body', 'types'], (state) => ({
    constraints: (bodyJson(state).depth?.constraints ?? []) as Json[], place: bodyPlace(state),
    follows: needed(state, 'depth'),
    solid: solidOf(state)?.json.type ?? null,
  }), ({ constraints, place, follows }) => {
    mark(part, store.state, 'depth', constraints.length);
    options.hidden = constraints.length === 0;
    if (constraints.length === 0) {
      return empty(follows ? 'No depth is known yet. Paint the outside with 0 and draw the core with 1.'
        : 'No depth is known.',
        button('Paint depth', () => store.set({ tool: 'fill', paint: 0 }),
          { icon: 'fill', keys: keyOf(context, 'fill') }));
    }
    return list('Where depth is known',
      constraints.map((constraint, i) => constraintRow(context, constraint, `${place}depth.constraints[${i}]`, i)));
  });
  placed(context, options, (place) =>
    [optionRows(app, `${place}depth`, { of: 'depth', more: ['centres', 'stroke_spacing'] }), depthLooks(context)]);
  return part.element;
}

/* Builds a host's children for the chosen body's place, and again when that changes. */
function placed({ app }: Context, host: HTMLElement, build: (place: string) => Child): void {
  live(app.store, host, ['document', 'body'], (state) => bodyPlace(state), build);
}

function constraintRow({ app }: Context, constraint: Json, path: string, index: number): HTMLElement {
  const depth = constraint.depth as number, words = constraintWords(constraint);
  return listRow({
    icon: words.icon, point: pointAt(app, `depth ${index}`),
    lead: h('span', { class: 'depth-dot', style: `--colour: ${paletteCss(depth)}`, 'aria-hidden': 'true' }),
    text: words.text, detail: words.detail, actions: [
      numberField(`Depth of ${words.text}`, { min: 0, max: 1 }, depth,
        (value) => void setValue(app, 'Set depth', `${path}.depth`, value),
        { key: path }).element,
      iconButton('trash', `Remove ${words.text}`, () => void operate(app, 'Remove depth',
        { op: 'stroke.remove', list: 'depth', index }),
        { look: 'plain', key: `${path}-` }),
    ],
  });
}

/** What a constraint of depth is, in words. */
export function constraintWords(constraint: Json): { text: string; detail?: string; icon: IconName } {
  if (constraint.faces === 'all') return { text: 'All faces', icon: 'fill' };
  if (constraint.faces) return { text: many(constraint.faces.length, 'face'), icon: 'face' };
  if (constraint.facing) {
    return { text: 'Faces that look',
      detail: `along ${pointWords(constraint.facing)}, within ${constraint.within ?? 45}°`, icon: 'face' };
  }
  if (constraint.stroke) return { text: 'Stroke', detail: many(constraint.stroke.length, 'point'), icon: 'stroke' };
  return { text: many(constraint.points?.length ?? 0, 'point'), icon: 'points' };
}

/** A point for people. */
export function pointWords(point: Point): string {
  return point.map((x) => write(Number(x.toPrecision(3)))).join(', ');
}

function depthLooks(context: Context): HTMLElement {
  const { store } = context.app;
  const isolines = checkbox('Lines of equal depth', store.state.isolines, (on) => store.set({ isolines: on }),
    { key: 'isolines', look: 'switch', tip: 'Drawn in the depth view' });
  store.on(['isolines'], () => isolines.set(store.state.isolines));
  return h('div', { class: 'stack looks' }, isolines.element, layerSlider(context));
}

/* ---- strokes ----------------------------------------------------------------------------------------------------- */

function strokeRows(context: Context, name: string, where: string, strokes: Point[][], of: string): Child {
  return list(name, strokes.map((stroke, i) => listRow({
    icon: 'stroke', point: pointAt(context.app, `${of} ${i}`), text: `Stroke ${i + 1}`,
    detail: `${where}${many(stroke.length, 'point')}`,
    actions: iconButton('trash', `Remove stroke ${i + 1}`,
      () => void operate(context.app, 'Remove stroke', { op: 'stroke.remove', list: of, index: i }),
      { look: 'plain', key: `${of} ${i}` }),
  })));
}

function directionSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('direction', 'Directions');
  const rows = h('div'), options = h('div');
  part.body.append(rows, options);
  live(store, rows, ['document', 'body', 'types'], (state) => ({
    strokes: (bodyJson(state).direction?.strokes ?? []) as Point[][], follows: needed(state, 'direction'),
    body: state.body,
  }), ({ strokes }) => {
    mark(part, store.state, 'direction', strokes.length);
    options.hidden = strokes.length === 0;
    if (strokes.length === 0) {
      return empty('Draw strokes along the fibres, on layers of depth or on sections.',
        button('Draw directions', () => store.set({ tool: 'direction' }),
          { icon: 'direction', keys: keyOf(context, 'direction') }));
    }
    return [strokeRows(context, 'Direction strokes', '', strokes, 'direction'),
            clearButton(() => operate(app, 'Clear directions', { op: 'direction.clear' }), 'Clear all strokes')];
  });
  placed(context, options, (place) => optionRows(app, `${place}direction`,
    { of: 'direction', more: ['lambda_r', 'lambda_d', 'constraint_weight', 'constraint_rows'] }));
  return part.element;
}

function clearButton(clear: () => Promise<boolean>, label: string): HTMLElement {
  return h('div', { class: 'actions' }, button(label, () => void clear(),
    { icon: 'trash', look: 'plain', key: label }));
}

function vectorsSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('vectors', 'Vectors');
  const rows = h('div'), options = h('div');
  part.body.append(rows, options);
  live(store, rows, ['document', 'body', 'types'], (state) => ({
    surface: (bodyJson(state).vectors?.surface ?? []) as Point[][],
    inside: (bodyJson(state).vectors?.inside ?? []) as Point[][],
    follows: needed(state, 'vectors'), body: state.body,
  }), ({ surface, inside }) => {
    mark(part, store.state, 'vectors', surface.length + inside.length);
    options.hidden = surface.length + inside.length === 0;
    if (options.hidden) {
      return empty('Draw strokes along the fibres: on the skin, or on sections for the inside.',
        button('Draw vectors', () => store.set({ tool: 'direction' }),
          { icon: 'direction', keys: keyOf(context, 'direction') }));
    }
    return [surface.length > 0 && strokeRows(context, 'Strokes on the skin', 'skin, ', surface, 'vectors.surface'),
            inside.length > 0 && strokeRows(context, 'Strokes inside', 'inside, ', inside, 'vectors.inside'),
            clearButton(() => operate(app, 'Clear vectors', { op: 'vectors.clear' }), 'Clear all strokes')];
  });
  placed(context, options, (place) => optionRows(app, `${place}vectors`,
    { of: 'vectors', more: ['constraint_weight', 'tolerance', 'seed'] }));
  return part.element;
}

/* ---- size -------------------------------------------------------------------------------------------------------- */

function scaleSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('scale', 'Texture size');
  const rows = h('div'), options = h('div');
  part.body.append(rows, options);
  live(store, rows, ['document', 'body', 'types'], (state) => ({
    points: (bodyJson(state).scale?.points ?? []) as Json[], place: bodyPlace(state), follows: needed(state, 'scale'),
  }), ({ points, place }) => {
    mark(part, store.state, 'scale', points.length);
    options.hidden = points.length < 2;
    if (points.length === 0) {
      return empty('How large the exemplar is on the model is not said yet.',
        button('Place it', () => store.set({ tool: 'scale' }), { icon: 'scale', keys: keyOf(context, 'scale') }));
    }
    const diagonal = app.model.diagonal(), soft: [number, number] = [diagonal / 200, diagonal];
    const spec = { min: 1e-9, max: 1e9, soft };
    return [list('Sizes', points.map((point, i) => {
      const path = `${place}scale.points[${i}]`;
      const remove = (): void => void (points.length > 1 ? removeValue(app, 'Remove size', path)
        : operate(app, 'Remove size', { op: 'scale.clear' }));
      return listRow({
        icon: 'scale', point: pointAt(app, `scale ${i}`), text: points.length > 1 ? `Size ${i + 1}` : 'Everywhere',
        detail: `at ${pointWords(point.point)}`, actions: [
          numberField('Size', spec, point.size, (size) => void setValue(app, 'Set size', `${path}.size`, size),
            { key: path }).element,
          iconButton('trash', 'Remove size', remove, { look: 'plain', key: `${path}-` })],
      });
    })), points.length > 1 && clearButton(() => operate(app, 'Clear sizes', { op: 'scale.clear' }), 'Clear all sizes')];
  });
  placed(context, options, (place) => optionRows(app, `${place}scale`,
    { of: 'size', more: ['lambda_r', 'lambda_d', 'constraint_weight', 'constraint_rows'], skip: ['carry'] }));
  return part.element;
}

/* ---- streamlines ------------------------------------------------------------------------------------------------- */

function linesSection(context: Context): HTMLElement {
  const { store } = context.app, part = section('lines', 'Streamlines', { folded: false });
  live(store, part.body, ['lines', 'linesOf', 'layer', 'document', 'body'], (state) => ({
    lines: state.lines, of: state.linesOf, layer: state.layer !== null,
    any: Boolean(bodyJson(state).depth || bodyJson(state).vectors),
    vectors: Boolean(bodyJson(state).vectors), depth: Boolean(bodyJson(state).depth),
    direction: Boolean(bodyJson(state).direction),
  }), ({ lines, of, any, vectors, depth, direction }) => {
    part.show(any);
    return [
      row('Drawn', segmented('Where streamlines are drawn', [
        { value: 'none', label: 'None' }, { value: 'body', label: 'Body' }, { value: 'skin', label: 'Skin' },
        { value: 'section', label: 'Cuts' }, { value: 'layer', label: 'Layer', disabled: !depth },
      ], lines, (value) => store.set(value === 'layer' && store.state.layer === null ? { lines: value, layer: 0.5 }
        : { lines: value }),
      { key: 'lines' }).element, { wide: true }),
      row('Along', choice('Along', [
        { value: '', label: 'what the texture follows' },
        { value: 'primary', label: 'the slope of depth', disabled: !depth },
        { value: 'secondary', label: 'the strokes', disabled: !depth || !direction },
        { value: 'tertiary', label: 'across both', disabled: !depth || !direction },
        { value: 'vectors', label: 'the vectors', disabled: !vectors },
      ], of, (value) => store.set({ linesOf: value }), { key: 'linesOf' }).element),
    ];
  });
  return part.element;
}
