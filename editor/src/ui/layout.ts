// What holds controls: sections that fold, rows of lists, tabs, empty places, and the edge that is dragged.

import { fill, h, recall, remember, set, uid, type Child } from './dom';
import { rove } from './controls';
import { icon, type IconName } from './icons';

export interface Section { element: HTMLElement; body: HTMLElement; note: HTMLElement; show(on: boolean): void; open(
  ): void }

/** A part of the inspector with a heading that folds it; whether it was folded is remembered. */
export function section(id: string, title: string, options: { folded?: boolean; inner?: boolean } = {}): Section {
  const at = `open.${id}`, bodyId = uid();
  const note = h('span', { class: 'section-note' }), body = h('div', { class: 'section-body', id: bodyId });
  const head = h('button', { type: 'button', class: 'section-head', 'aria-controls': bodyId,
    onclick: () => { fold(!body.hidden); remember(at, body.hidden ? 'no' : 'yes'); } },
  icon('chevron', 14), h('span', { class: 'section-title' }, title), note);
  const fold = (folded: boolean): void => { body.hidden = folded; set(head, 'aria-expanded', !folded); };
  fold((recall(at) ?? (options.folded ? 'no' : 'yes')) === 'no');
  const heading = h(options.inner ? 'h4' : 'h3', null, head);
  const element = h('section', { class: options.inner ? 'section inner' : 'section', 'data-section': id }, heading,
    body);
  return { element, body, note, show(on) { element.hidden = !on; }, open() { fold(false); } };
}

export interface RowParts {
  icon?: IconName;
  lead?: Child;
  text: Child;
  detail?: Child;
  actions?: Child;
  more?: Child;                     // under the row
  chosen?: boolean;
  choose?: () => void;
  /** Told when the row is pointed at or has the focus, and when not any more. */
  point?: (on: boolean) => void;
  key?: string;
  tip?: string;
}

/** A row of a list; with `choose` its text is a button that picks it. */
export function listRow(parts: RowParts): HTMLLIElement {
  const text = [parts.icon && icon(parts.icon, 16), parts.lead, h('span', { class: 'list-text' },
    h('span', { class: 'list-title' }, parts.text), parts.detail && h('span', { class: 'list-detail' }, parts.detail))];
  const main = parts.choose
    ? h('button', { type: 'button', class: 'list-main', onclick: parts.choose, 'data-key': parts.key,
        'aria-pressed': parts.chosen ?? false, 'data-tip': parts.tip }, text)
    : h('span', { class: 'list-main', 'data-tip': parts.tip }, text);
  const { point } = parts, on = point && (() => point(true)), off = point && (() => point(false));
  return h('li', { class: parts.chosen ? 'list-row chosen' : 'list-row', onpointerenter: on, onpointerleave: off,
    onfocusin: on, onfocusout: off },
    h('div', { class: 'list-line' }, main, parts.actions && h('span', { class: 'list-actions' }, parts.actions)),
    parts.more);
}

/** A list with a name. */
export function list(name: string, rows: Child): HTMLUListElement {
  return h('ul', { class: 'list', 'aria-label': name }, rows);
}

/** Where nothing is yet: one sentence, and the button that changes it. */
export function empty(text: Child, action?: Child): HTMLElement {
  return h('div', { class: 'empty' }, h('p', null, text), action);
}

export interface Tab { id: string; label: string; icon: IconName; panel: HTMLElement }

/** Tabs over panels; arrow keys go through them. */
export function tabs(name: string, all: Tab[], chosen: string, choose: (id: string) => void):
  { element: HTMLElement; show(id: string): void } {
  const buttons = all.map((tab) => {
    const id = uid();
    tab.panel.id ||= uid();
    set(tab.panel, 'role', 'tabpanel');
    set(tab.panel, 'aria-labelledby', id);
    return h('button', { type: 'button', role: 'tab', class: 'tab', id, 'aria-controls': tab.panel.id,
      onclick: () => choose(tab.id) }, icon(tab.icon, 18), h('span', null, tab.label));
  });
  const element = h('div', { class: 'tabs', role: 'tablist', 'aria-label': name }, buttons);
  element.addEventListener('keydown', (event) => rove(event, buttons));
  const show = (id: string): void => all.forEach((tab, i) => {
    tab.panel.hidden = tab.id !== id;
    set(buttons[i], 'aria-selected', tab.id === id);
    buttons[i].tabIndex = tab.id === id ? 0 : -1;
  });
  show(chosen);
  return { element, show };
}

/** An edge that makes what is left of it (`right of`), right of it or above it (`below`) larger or smaller; arrow keys do
    too. `where`: on which side of that it lies. */
export function splitter(name: string, size: () => number, change: (size: number) => void, range: [number, number],
  where: 'left of' | 'right of' | 'below' = 'left of'): HTMLElement {
  const level = where === 'below', sign = where === 'left of' ? -1 : 1;
  const element = h('div', { class: level ? 'splitter level' : 'splitter', role: 'separator', tabindex: 0,
    'aria-orientation': level ? 'horizontal' : 'vertical', 'aria-label': name, 'aria-valuemin': range[0], 'aria-valuemax': range[1],
    'aria-valuenow': size() });
  const to = (next: number): void => {
    const held = Math.round(Math.min(range[1], Math.max(range[0], next)));
    change(held);
    set(element, 'aria-valuenow', held);
  };
  const along = (event: PointerEvent): number => (level ? event.clientY : event.clientX);
  element.addEventListener('pointerdown', (event) => {
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    const from = along(event), before = size();
    const move = (next: PointerEvent): void => to(before + sign * (along(next) - from));
    element.addEventListener('pointermove', move);
    element.addEventListener('lostpointercapture', () => element.removeEventListener('pointermove', move),
      { once: true });
  });
  const keys: { [key: string]: number } = level ? { ArrowUp: -16, ArrowDown: 16 } : { ArrowLeft: -16, ArrowRight: 16 };
  element.addEventListener('keydown', (event) => {
    const step = keys[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    to(size() + sign * step);
  });
  return element;
}

/** A badge: one word about something. */
export function badge(text: string, tone: 'plain' | 'good' | 'due' | 'bad' = 'plain', tip?: string): HTMLElement {
  return h('span', { class: `badge ${tone}`, 'data-tip': tip }, text);
}

/** Shows a note beside a section's title. */
export function setNote(part: Section, ...note: Child[]): void { fill(part.note, note); }
