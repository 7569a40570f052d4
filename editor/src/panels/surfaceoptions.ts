// What the tools that work on surfaces can be told, and which surfaces are in sight.

import { showSurface } from '../surfaceview';
import { boundsBody, surfacesOf, type State } from '../store';
import { brushRadius } from '../tools/surface';
import { colourField, iconButton, row, segmented } from '../ui/controls';
import { fill, h, live, type Child } from '../ui/dom';
import { list, listRow, section, setNote } from '../ui/layout';
import { slider } from '../ui/slider';
import { commandButton, refreshCommand, type Context } from './context';
import { labelled } from './tooloptions';

/* ---- the brush --------------------------------------------------------------------------------------------------- */

/** Of the tool that paints: what, in which colour, how wide, on which side, how often. */
export function paintOptions(context: Context): Child[] {
  const { store } = context.app, { paintWhat } = store.state;
  return [
    segmented('What is painted', [
      { value: 'colour', label: 'Colour', tip: 'Colours of the surface’s sides' },
      { value: 'blur', label: 'Blur', tip: 'How softly the sides’ colours flow into each other' },
    ], paintWhat, (what) => store.set({ paintWhat: what }), { key: 'paint what' }).element,
    ...(paintWhat === 'colour' ? [colourChooser(context), sideChoice(context)] : [blurSlider(context)]),
    radiusSlider(context), repeatChoice(context), ...(paintWhat === 'colour' ? [flipButton(context)] : []),
  ];
}

function colourChooser({ app }: Context): HTMLElement {
  const { store } = app;
  const own = colourField('Colour', store.state.paintColour, (paintColour) => store.set({ paintColour }), { key: 'paint colour' });
  const recent = h('span', { class: 'recent-colours', role: 'group', 'aria-label': 'Colours painted last' });
  const refresh = (): void => {
    const { paintColour, recentColours } = store.state;
    own.set(paintColour);
    fill(recent, recentColours.map((colour) => h('button', { type: 'button', class: 'recent-colour', style: `--colour: ${colour}`,
      'aria-label': colour, 'data-tip': colour, 'data-key': `colour ${colour}`, onclick: () => store.set({ paintColour: colour }) })));
  };
  const stop = store.on(['paintColour', 'recentColours'], () => (made.isConnected ? refresh() : stop()));
  const made = h('div', { class: 'option' }, own.element, recent);
  refresh();
  return made;
}

function sideChoice({ app: { store } }: Context): HTMLElement {
  return labelled('Side', segmented('Side', [
    { value: 'both', label: 'Both', tip: 'Both sides of the surface' },
    { value: 'front', label: 'Front', tip: 'The side that looks outward' },
    { value: 'back', label: 'Back', tip: 'The side that looks inward' },
  ], store.state.paintSide, (paintSide) => store.set({ paintSide }), { key: 'paint side' }).element);
}

function repeatChoice({ app: { store } }: Context): HTMLElement {
  return labelled('Repeat', segmented('Repeat', [
    { value: 'once', label: 'Once', tip: 'Where it is drawn' },
    { value: 'folds', label: 'Folds', tip: 'In every fold' },
    { value: 'around', label: 'Around', tip: 'All round the axis' },
  ], store.state.paintRepeat, (paintRepeat) => store.set({ paintRepeat }), { key: 'paint repeat' }).element);
}

function radiusSlider({ app }: Context): HTMLElement {
  const { store, viewport } = app, { diagonal } = viewport;
  const set = (paintRadius: number): void => store.set({ paintRadius });
  const control = slider('Width of the brush', { min: 1e-9, max: 1e9, soft: [diagonal / 500, diagonal / 4] }, brushRadius(app), set,
    { key: 'paint radius', moving: set });
  const stop = store.on(['paintRadius'], () => (control.element.isConnected ? control.set(brushRadius(app)) : stop()));
  return labelled('Brush', control.element);
}

function blurSlider({ app }: Context): HTMLElement {
  const { store, viewport } = app;
  const set = (paintBlur: number): void => store.set({ paintBlur });
  return labelled('Blur', slider('Blur', { min: 0, max: 1e9, soft: [0, viewport.diagonal / 20] }, store.state.paintBlur, set,
    { key: 'paint blur', moving: set }).element);
}

function flipButton(context: Context): HTMLElement {
  const { store } = context.app, made = commandButton(context, 'surface-flip', { only: 'icon', icon: 'flip' });
  const refresh = (): void => refreshCommand(context, made, 'surface-flip');
  const stop = store.on(['selectedSurface', 'document', 'body'], () => (made.isConnected ? refresh() : stop()));
  refresh();
  return made;
}

/** Of the tool that erases: which part goes. */
export function eraseOptions({ app: { store } }: Context): Child[] {
  return [labelled('What goes', segmented('What goes', [
    { value: 'click', label: 'Ask', tip: 'The part that is clicked when the stroke is drawn' },
    { value: 'right', label: 'Right', icon: 'lower', tip: 'What lies right of the stroke' },
    { value: 'left', label: 'Left', icon: 'upper', tip: 'What lies left of the stroke' },
  ], store.state.eraseSide, (eraseSide) => store.set({ eraseSide }), { key: 'erase side' }).element)];
}

/* ---- what is in sight -------------------------------------------------------------------------------------------- */

/** A switch for one surface: is it in sight? */
export function surfaceEye({ app }: Context, name: string): HTMLButtonElement {
  const shown = app.store.state.shownSurfaces[name] !== false;
  const made = iconButton(shown ? 'eye' : 'hidden', shown ? `Hide ${name}` : `Show ${name}`,
    () => showSurface(app, name, !shown), { look: 'plain', key: `eye ${name}` });
  made.setAttribute('aria-pressed', String(shown));
  return made;
}

/** Section of the Look tab: the skin about the surfaces, and an eye for each of them. */
export function surfacesSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('surfaces', 'Surfaces inside'), rows = h('div');
  const set = (skin: number): void => store.set({ skin, mode: 'surfaces' });
  const skin = slider('Opacity of the skin', { min: 0, max: 1, default: 0.25 }, store.state.skin, set, { key: 'skin', moving: set });
  store.on(['skin'], () => skin.set(store.state.skin));
  part.body.append(row('Skin', skin.element, { tip: '0 hides the skin about the surfaces, 1 shows nothing else.' }), rows);
  live(store, rows, ['document', 'body', 'shownSurfaces', 'selectedSurface'], (state: State) => ({
    chosen: state.selectedSurface, names: surfacesOf(state).map(({ name, kind }) => ({ name, kind,
      shown: state.shownSurfaces[name] !== false, outer: boundsBody(state, state.body, name) })),
  }), ({ chosen, names }) => {
    part.show(names.length > 0);
    setNote(part, names.length ? String(names.length) : null);
    return list('Surfaces', names.map(({ name, outer }) => listRow({
      icon: outer ? 'body' : 'nested', text: name, key: `surface ${name}`, chosen: name === chosen,
      detail: outer ? 'the body’s outside' : null, actions: [surfaceEye(context, name)],
      choose: () => store.set({ selectedSurface: name === chosen ? null : name, mode: 'surfaces' }),
    })));
  });
  return part.element;
}
