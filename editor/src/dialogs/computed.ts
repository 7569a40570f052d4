// Computed textures to start from: the shipped examples of them, brought to the size of a body.

import type { App } from '../app';
import { placed } from '../graph';
import type { Json, Point } from '../protocol';
import { bodyJson, bodyKey, bodyPlace, freeName, solidOf } from '../store';
import { h } from '../ui/dom';
import bubbles from '../../../examples/bubbles.pith';
import granite from '../../../examples/granite.pith';
import marble from '../../../examples/marble.pith';
import wood from '../../../examples/wood.pith';

interface Computed { name: string; about: string; examples: string; document: Json }

/** All there are, in the order of the dialog. */
export const computedTable: readonly Computed[] = [
  { name: 'wood', document: wood, about: 'Rings of growth about a leaning trunk, and fibres along it.', examples: 'Boards, blocks, turned bowls' },
  { name: 'granite', document: granite, about: 'Grains cast along three axes and summed, which overflow.', examples: 'Polished stone' },
  { name: 'marble', document: marble, about: 'Bent sheets, fine veins, and a haze between them.', examples: 'Statues, columns' },
  { name: 'bubbles', document: bubbles, about: 'Balls of many sizes and colours in a paler ground.', examples: 'Terrazzo, nougat, sausage' },
];

/** A computed texture by its name; undefined for a type's word. */
export function computedOf(name: string): Computed | undefined { return computedTable.find((each) => each.name === name); }

/** The picture of a computed texture. */
export function computedPicture(name: string, look: string): HTMLElement {
  const made = h('span', { class: look });
  const image = h('img', { src: `types/${name}.jpg`, alt: '', onload: () => made.prepend(image) });
  return made;
}

/** A card of the dialog. */
export function computedCard(of: Computed, choose: () => void): HTMLButtonElement {
  return h('button', { type: 'button', role: 'radio', class: 'type-option', onclick: choose },
    computedPicture(of.name, 'type-picture'),
    h('span', { class: 'type-name' }, of.name.charAt(0).toUpperCase() + of.name.slice(1)),
    h('span', { class: 'type-about' }, of.about), h('span', { class: 'type-examples' }, of.examples));
}

/** The operations that make the chosen body of a computed texture: its graph takes the place of another computed solid,
    or comes beside the others and is chosen. Throws an Error with a sentence while nobody knows how large the body is. */
export function computedOperations(app: App, name: string): Json[] {
  const { state } = app.store, box = app.model.meshes.get(state.body)?.box, body = bodyJson(state);
  if (!box) throw new Error('The mesh is not here yet; wait until it is built and try again.');
  const [low, high] = box, middle = low.map((least, k) => (least + high[k]) / 2) as Point;
  const from = computedOf(name)!.document, solid = from.solids[0] as Json, present = solidOf(state);
  const others = (body.solids ?? []) as Json[], replaces = present?.json.kind === 'procedural' ? present : null;
  const own = freeName(name, (wish) => others.some((each) => each !== replaces?.json && each.name === wish));
  const value = { ...placed(solid, state.functions, Math.hypot(...low.map((least, k) => high[k] - least)) / madeFor(from), middle), name: own };
  const path = replaces?.place ?? `${bodyPlace(state)}solids[${others.length}]`;
  return [{ op: 'set', path, value },
    ...(others.length > 0 ? [{ op: 'solid.choose', ...bodyKey(state), name: own }] : [])];
}

/* The diagonal of the body that an example was made for, as its shape says. */
function madeFor({ shape: { block, slab } }: Json): number {
  if (block) return Math.hypot(block.size_x, block.size_y, block.size_z);
  return Math.hypot(2 * (slab.radius_x ?? 1), 2 * (slab.radius_y ?? 1), slab.top - slab.bottom);
}
