// Dialogs and messages: what stands before the page, and what is said to people.

import { h, set, uid, type Child } from './dom';
import { button, iconButton, textField } from './controls';
import { icon } from './icons';

export interface DialogOptions {
  title: string;
  /** Under the title, one sentence. */
  about?: Child;
  body: Child;
  /** At the lower end, right. */
  actions?: Child;
  class?: string;
  closed?: () => void;
}

/** Opens a dialog over the page. The browser keeps the focus in it; Escape, the cross and a click beside it close it,
    and the focus goes back to where it was. Returns the way to close it. */
export function openDialog(options: DialogOptions): () => void {
  const before = document.activeElement as HTMLElement | null, title = uid();
  const close = (): void => dialog.close();
  const dialog = h('dialog', { class: `dialog ${options.class ?? ''}`, 'aria-labelledby': title },
    h('header', null, h('h2', { id: title }, options.title),
      iconButton('close', 'Close', close, { look: 'plain', keys: 'Esc' })),
    options.about && h('p', { class: 'dialog-about' }, options.about),
    h('div', { class: 'dialog-body', tabindex: -1, autofocus: true }, options.body),
    options.actions && h('footer', null, options.actions));
  dialog.addEventListener('close', () => {
    dialog.remove();
    if (before?.isConnected) before.focus({ preventScroll: true });
    options.closed?.();
  });
  dialog.addEventListener('pointerdown', (event) => {
    const box = dialog.getBoundingClientRect();
    const inside = event.clientX >= box.left && event.clientX <= box.right && event.clientY >= box.top &&
      event.clientY <= box.bottom;
    if (event.target === dialog && !inside) close();
  });
  dialog.addEventListener('keydown', (event) => event.stopPropagation());
  document.body.append(dialog);
  dialog.showModal();
  return close;
}

export interface Question {
  title: string;
  label: string;
  value: string;
  act: string;
  /** What is said to no text at all. */
  none: string;
  /** Does it; `insist` when it was objected to before. */
  run: (text: string, insist: boolean) => Promise<Objection | null>;
}

/** Why an answer was not taken, a sentence, and the word of the button that insists on it, if one may. */
export interface Objection { why: string; insist?: string }

/** Asks for a line of text; stays open until it was taken, and says beside the field why it was not. */
export function askText(question: Question): void {
  const id = uid(), why = h('p', { class: 'objection', id: uid(), role: 'alert' });
  const input = textField(question.label, question.value, () => {}, { id }).element as HTMLInputElement;
  const act = button(question.act, () => void go(false), { look: 'main' });
  const insist = button('', () => void go(true), { look: 'danger' });
  const object = (objection: Objection | null): void => {
    why.textContent = objection?.why ?? '';
    set(input, 'aria-invalid', objection ? true : null);
    insist.hidden = !objection?.insist;
    insist.textContent = objection?.insist ?? '';
  };
  const go = async (insisting: boolean): Promise<void> => {
    const text = input.value.trim();
    act.disabled = insist.disabled = true;
    const objection = text ? await question.run(text, insisting) : { why: question.none };
    act.disabled = insist.disabled = false;
    if (!objection) return close();
    object(objection);
    input.focus();
  };
  input.addEventListener('input', () => object(null));
  input.addEventListener('keydown', (event) => { if (event.key === 'Enter') { event.preventDefault(); void go(false); } });
  set(input, 'aria-describedby', why.id);
  object(null);
  const close = openDialog({ title: question.title, class: 'small',
    body: h('div', { class: 'stack' }, h('label', { for: id }, question.label), input, why),
    actions: [button('Cancel', () => close()), insist, act] });
  input.select();
}

export type Tone = 'info' | 'done' | 'warning';

/** Says things to people, one above another, for a while or until they are put away. */
export class Messages {
  readonly element = h('div', { class: 'messages', role: 'log', 'aria-live': 'polite', 'aria-label': 'Messages' });

  /** Shows a sentence; the same one again only shows it longer. */
  say(text: string, tone: Tone = 'info', action?: { label: string; run: () => void }): void {
    for (const shown of [...this.element.children]) {
      if (shown.querySelector('.message-text')?.textContent === text) shown.remove();
    }
    const away = (): void => message.remove();
    const message = h('div', { class: `message ${tone}` },
      icon(tone === 'done' ? 'check' : tone === 'warning' ? 'warning' : 'info', 18),
      h('span', { class: 'message-text' }, text),
      action && button(action.label, () => { away(); action.run(); }),
      iconButton('close', 'Put away', away, { look: 'plain' }));
    this.element.append(message);
    while (this.element.children.length > 4) this.element.firstChild?.remove();
    let timer = 0;
    const stay = (): void => clearTimeout(timer);
    const wait = (): void => { // not while it is pointed at or has the focus
      stay();
      if (message.matches(':hover, :focus-within')) return;
      timer = window.setTimeout(away, 4000 + 60 * text.length);
    };
    message.addEventListener('pointerenter', stay);
    message.addEventListener('focusin', stay);
    message.addEventListener('pointerleave', wait);
    message.addEventListener('focusout', () => queueMicrotask(wait));
    wait();
  }
}

/** A thin bar of how far something is; NaN while nobody knows. */
export function progress(label: string): { element: HTMLElement; set(fraction: number): void } {
  const bar = h('span', { class: 'progress-bar' });
  const element = h('span', { class: 'progress', role: 'progressbar', 'aria-label': label, 'aria-valuemin': 0,
    'aria-valuemax': 100 }, bar);
  return {
    element,
    set(fraction) {
      const known = Number.isFinite(fraction);
      element.classList.toggle('unknown', !known);
      set(element, 'aria-valuenow', known ? Math.round(100 * fraction) : null);
      bar.style.width = known ? `${100 * fraction}%` : '';
    },
  };
}
