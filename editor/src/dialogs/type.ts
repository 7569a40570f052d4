// The dialog of texture types (Takayama et al. 2008, §4; thesis 2011, §5.2): a card each, and what choosing one adds.

import type { App } from '../app';
import { presentIn, startingOperations } from '../fields';
import type { Json, TypeNeeds } from '../protocol';
import { bodyJson, bodyKey, bodyPlace, solidOf } from '../store';
import { needWords, typeFacts, typeTable } from '../types';
import { button, rove } from '../ui/controls';
import { fill, h, set } from '../ui/dom';
import { openDialog } from '../ui/dialog';
import { icon } from '../ui/icons';
import { exemplarName, typePicture } from '../panels/exemplars';
import { computedCard, computedOf, computedOperations, computedTable } from './computed';

interface Shipped { path: string; name: string; shipped: boolean }

const isCalled = (path: string | undefined, exemplar: string): boolean => path?.split('/').pop() === `${exemplar}.json`;

/** Opens the dialog for the chosen body. */
export function typeDialog(app: App): void {
  const { state } = app.store, solid = solidOf(state)?.json;
  const before = (solid?.kind === 'lapped' ? solid.type ?? '1-B' : '') as string;
  let chosen = before || computedOf(solid?.name)?.name || '1-B', recipes: Shipped[] = [], swap = !before;
  const body = state.bodies.length > 1 ? ` of ${state.bodies[state.body]?.name}` : '';
  const note = h('div', { class: 'type-note', 'aria-live': 'polite' }),
    act = button('', () => void use(), { look: 'main' });
  const cards = typeTable.map((facts) => card(app, facts.type,
    () => { chosen = facts.type; swap = !before || !suits(facts.type); refresh(); }));
  const grid = h('div', { class: 'type-cards', role: 'radiogroup', 'aria-label': 'Texture type' }, cards);
  const computed = computedTable.map((each) => computedCard(each, () => { chosen = each.name; refresh(); }));
  const computedGrid = h('div', { class: 'type-cards', role: 'radiogroup', 'aria-label': 'Computed texture' }, computed);
  const sketched = h('p', { class: 'type-sketched' }, h('span', null, 'Colours that flow between surfaces, which are drawn on a picture of the ' +
    'thing cut along its axis and one of it cut across.'), button('Open the sketch', () => { close(); app.store.set({ sketching: true }); },
  { icon: 'sketch', key: 'type sketch' }));
  grid.addEventListener('keydown', (event) => rove(event, cards));
  computedGrid.addEventListener('keydown', (event) => rove(event, computed));

  /* Does the present exemplar suit a type? Types 0 want exemplars that tile in depth too, and each of them another; one
     that was made for layers shows something in both types 1. */
  function suits(type: string): boolean {
    const { layered, recipe } = solid?.exemplar ?? {};
    if (!before || before === type) return true;
    if (before[0] !== type[0]) return layered ? Boolean(layered.homogeneous) === (type[0] === '0') : false;
    return type[0] === '1' || !isCalled(recipe, typeFacts(before)!.exemplar);
  }

  /* One of all cards is taken; each group can be reached. */
  function mark(group: HTMLElement[], words: string[]): void {
    group.forEach((each, i) => {
      set(each, 'aria-checked', words[i] === chosen);
      each.tabIndex = words[i] === chosen || (i === 0 && !words.includes(chosen)) ? 0 : -1;
    });
  }

  function refresh(): void {
    mark(cards, typeTable.map(({ type }) => type));
    mark(computed, computedTable.map(({ name }) => name));
    if (computedOf(chosen)) {
      fill(note, h('p', null, icon('noise', 16),
        'Computed from the place alone, at the size of the body: it needs no depth and no directions, and stays sharp.'));
      act.replaceChildren(h('span', { class: 'button-label' }, `Use ${chosen}`));
      return;
    }
    const facts = typeFacts(chosen)!, needs = state.types[chosen], present = presentIn(bodyJson(state));
    const adds = needKeys(needs).filter((need) => !present[need]).map((need) => needWords[need]);
    const offer = recipes.find(({ path }) => isCalled(path, facts.exemplar));
    fill(note,
      adds.length > 0 && h('p', null, icon('plus', 16),
        `Adds ${words(adds)} to start from; you can change ${adds.length > 1 ? 'them' : 'it'} afterwards.`),
      before && before !== chosen && offer && offer.path !== solid?.exemplar?.recipe
        && swapChoice(facts.exemplar, exemplarName(solid!.exemplar), swap, (on) => { swap = on; }),
      !before && offer && h('p', null, icon('image', 16),
        `Starts with the exemplar “${exemplarName({ recipe: offer.path })}”.`));
    act.replaceChildren(h('span', { class: 'button-label' }, before === chosen ? 'Keep' : `Use type ${chosen}`));
  }

  async function compute(): Promise<void> {
    try {
      await app.actions.apply(`Make it of ${chosen}`, computedOperations(app, chosen));
    } catch (reason) {
      app.actions.complain((reason as Error).message);
    }
  }

  async function use(): Promise<void> {
    if (computedOf(chosen)) {
      close();
      return compute();
    }
    const facts = typeFacts(chosen)!, offer = recipes.find(({ path }) => isCalled(path, facts.exemplar));
    close();
    if (chosen === before) return;
    try {
      const operations = typeOperations(app, chosen, swap ? offer?.path : undefined);
      await app.actions.apply(`Type ${chosen}`, operations);
    } catch (reason) {
      app.actions.complain((reason as Error).message);
    }
  }

  const close = openDialog({
    title: `Texture type${body}`, about: 'What the inside follows. Everything can be changed later.', class: 'wide',
    body: [grid, h('h3', { class: 'type-group' }, 'Computed'), computedGrid, h('h3', { class: 'type-group' }, 'Sketched'), sketched, note], actions: [button('Cancel', () => close()), act],
  });
  refresh();
  (computedOf(chosen) ? computed : cards).find((each) => each.tabIndex === 0)?.focus();
  app.connection.ask('files', { kind: 'recipe' }).then(({ files }) => { recipes = files as Shipped[]; refresh(); },
    (reason: Error) => app.actions.complain(reason.message));
}

function swapChoice(suited: string, name: string, on: boolean, choose: (on: boolean) => void): HTMLElement {
  const box = h('input', { type: 'checkbox', class: 'check', onchange: () => choose(box.checked) });
  box.checked = on;
  return h('label', { class: 'check-label' }, box,
    `Take the exemplar “${suited}” instead of “${name}”`);
}

function card(app: App, type: string, choose: () => void): HTMLButtonElement {
  const facts = typeFacts(type)!, needs = app.store.state.types[type], present = presentIn(bodyJson(app.store.state));
  return h('button', { type: 'button', role: 'radio', class: 'type-option', onclick: choose },
    typePicture(type, 'type-picture'), h('span', { class: 'type-name' }, facts.name),
    h('span', { class: 'type-about' }, facts.about),
    h('span', { class: 'type-examples' }, facts.examples),
    h('span', { class: 'needs' }, needKeys(needs).map((need) =>
      h('span', { class: present[need] ? 'need there' : 'need' },
      icon(present[need] ? 'check' : 'plus', 12), needWords[need]))));
}

function needKeys(needs: TypeNeeds | undefined): (keyof TypeNeeds)[] {
  return (['depth', 'direction', 'vectors', 'scale'] as const).filter((need) => needs?.[need]);
}

function words(all: string[]): string {
  return all.length < 2 ? all.join('') : `${all.slice(0, -1).join(', ')} and ${all.at(-1)}`;
}

/** The operations that give the chosen body a texture type: the type itself, a solid where there is none, an exemplar
    where one is given, and a start for every field the type needs and the body lacks. Throws an Error with a sentence
    when the mesh has no core to start from. */
export function typeOperations(app: App, type: string, recipe?: string): Json[] {
  const { state } = app.store, solid = solidOf(state), body = bodyKey(state), place = bodyPlace(state);
  const needs = state.types[type], json = bodyJson(state);
  const starting = startingOperations(needs, presentIn(json), app.model.meshes.get(state.body))
    .map((operation) => ({ ...operation, ...body }));
  const lapped = ((json.solids ?? []) as Json[]).findIndex((each) => each.kind === 'lapped');
  if (solid && solid.json.kind !== 'lapped' && lapped >= 0) { // a lapped solid that was chosen before
    const { name, type: old = '1-B' } = json.solids[lapped] as Json;
    return [...starting, { op: 'solid.choose', ...body, name }, { op: 'solid.type', ...body, type },
      ...(recipe && old !== type ? [{ op: 'set', path: `${place}solids[${lapped}].exemplar`, value: { recipe } }] : [])];
  }
  if (solid?.json.kind === 'lapped') {
    const exemplar = recipe ? [{ op: 'set', path: `${solid.place}.exemplar`, value: { recipe } }] : [];
    return [...starting, { op: 'solid.type', ...body, type }, ...exemplar];
  }
  if (!recipe) throw new Error('No recipe of an exemplar was found to start from; put one into the document’s folder.');
  const index = ((json.solids ?? []) as Json[]).length,
    name = `${typeFacts(type)!.exemplar}${index ? ` ${index + 1}` : ''}`;
  const fresh = { name, kind: 'lapped', type, exemplar: { recipe }, ...(needs.scale ? { blend: 'variance' } : {}) };
  return [...starting, { op: 'set', path: `${place}solids[${index}]`, value: fresh },
    { op: 'solid.choose', ...body, name }];
}
