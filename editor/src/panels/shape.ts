// Inspector, "Shape": the numbers of bodies that the program makes, how tetrahedra fill them, and the relief.

import { removeValue, setValue } from '../app';
import { bodyJson, bodyPlace } from '../store';
import { button } from '../ui/controls';
import { h, live } from '../ui/dom';
import { empty, section, setNote } from '../ui/layout';
import type { Context } from './context';
import { join, optionRows, type OptionSettings } from './options';
import { profileEditor } from './profile';

/** The section; it follows the chosen body. */
export function shapeSection(context: Context): HTMLElement {
  const { app } = context, part = section('shape', 'Shape', { folded: true });
  live(app.store, part.body, ['document', 'body'], (state) => {
    const { shape, displacement, finish } = bodyJson(state);
    return { place: bodyPlace(state), kind: Object.keys(made).find((word) => shape?.[word]) ?? 'mesh',
      bounds: (shape?.surfaces ?? null) as string[] | null, placed: shape?.place !== undefined, shiny: finish !== undefined, file: shape?.mesh as string | undefined,
             refine: shape?.refine !== undefined, relief: displacement !== undefined };
  }, ({ place, kind, bounds, placed, shiny, file, refine, relief }) => {
    setNote(part, file ? file.split('/').pop() : bounds ? 'surfaces' : kind);
    return [
      file ? h('p', { class: 'quiet' }, `The mesh is ${file}.`)
        : bounds ? h('p', { class: 'quiet' }, `It is bounded by its surfaces: ${bounds.join(', ')}.`)
        : optionRows(app, `${place}shape.${kind}`, { of: kind, ...made[kind] }),
      kind === 'turned' && profileEditor(app, `${place}shape.turned.profile`),
      folded('place', 'Place', placed ? placeRows(context, place) : empty('It stands where it was made.',
        button('Move, turn or scale it', () => void setValue(app, 'Place the body', join(place, 'shape.place'), {}),
          { key: 'place' }))),
      folded('finish', 'Finish', shiny ? optionRows(app, `${place}finish`, { of: 'finish' })
        : empty('Its surface mirrors nothing. Polished stone and varnish do, in pictures with bounces.',
          button('Polish', () => void setValue(app, 'Polish the body', join(place, 'finish'), { reflectivity: 0.04 }),
            { key: 'finish' }))),
      folded('tets', 'Tetrahedra', optionRows(app, `${place}shape.tets`,
        { of: 'mesher', only: ['tetrahedra', 'edge_length', 'mesher', 'radius_edge', 'time_limit', 'memory_limit'],
        more: ['mesher', 'radius_edge', 'time_limit', 'memory_limit'],
        soft: { tetrahedra: [0, 100000], edge_length: [0, app.model.diagonal() / 5] } })),
      folded('refine', 'Finer at the core', refine ? optionRows(app, `${place}shape.refine`, { of: 'refining' })
        : empty(
        'Smaller tetrahedra where depth turns quickly keep the texture there from smearing.',
        button('Refine', () => void setValue(app, 'Refine the core', join(place, 'shape.refine'), {}),
          { key: 'refine' }))),
      folded('relief', 'Relief', relief ? reliefRows(context, place)
        : empty('The skin is smooth. A channel of the texture can move it: bark, pores, seeds.',
        button('Add relief', () => void setValue(app, 'Add relief', join(place, 'displacement'),
          { amount: Number((app.model.diagonal() / 10).toPrecision(2)) }), { key: 'relief' }))),
    ];
  });
  return part.element;
}

/* What is used of ranges that go far beyond. */
const length: [number, number] = [0.05, 5], height: [number, number] = [-3, 3];
const made: { [kind: string]: OptionSettings } = {
  fruit: { soft: { radius_x: length, radius_y: length, radius_z: length }, more: ['taper', 'detail', 'seed'] },
  block: { soft: { size_x: length, size_y: length, size_z: length } },
  turned: {},
  slab: { soft: { radius_x: length, radius_y: length, bottom: height, top: height, bottom_wave: [0, 1],
    top_wave: [0, 1], wave_size: length },
          more: ['wave_size', 'detail', 'bottom_seed', 'top_seed'] },
};

function folded(id: string, title: string, body: HTMLElement): HTMLElement {
  const part = section(`shape.${id}`, title, { folded: true, inner: true });
  part.body.append(body);
  return part.element;
}

function placeRows({ app }: Context, place: string): HTMLElement {
  const far = app.model.diagonal(), turn: [number, number] = [-180, 180], move: [number, number] = [-2 * far, 2 * far];
  return h('div', null, optionRows(app, `${place}shape.place`, { of: 'place', soft: { scale: [0.1, 10], turn_x: turn,
    turn_y: turn, turn_z: turn, move_x: move, move_y: move, move_z: move } }),
  h('div', { class: 'actions' }, button('Back to where it was made',
    () => void removeValue(app, 'Remove place', join(place, 'shape.place')), { look: 'plain', key: 'no place' })));
}

function reliefRows({ app }: Context, place: string): HTMLElement {
  const most = app.model.diagonal() / 2;
  return h('div', null, optionRows(app, `${place}displacement`,
    { of: 'relief', only: ['amount', 'middle', 'channel', 'edge', 'max_triangles'],
    more: ['edge', 'max_triangles'], soft: { amount: [-most, most], middle: [-1, 1], edge: [0, most / 5] } }),
  h('div', { class: 'actions' }, button('Smooth skin',
    () => void removeValue(app, 'Remove relief', join(place, 'displacement')), { look: 'plain', key: 'no relief' })));
}
