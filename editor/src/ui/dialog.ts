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

/** Asks before something that cannot be taken back, or that there are two ways to do. */
export function confirmDialog(title: string, about: string,
  act: { label: string; run: () => void; danger?: boolean }): void {
  const close = openDialog({ title, body: h('p', null, about), class: 'small', actions: [
    button('Cancel', () => close()),
    button(act.label, () => { close(); act.run(); }, { look: act.danger ? 'danger' : 'main' }),
  ] });
}

/** Asks for a line of text. */
export function askText(title: string, label: string, value: string, act: string, run: (value: string) => void): void {
  const id = uid(), field = textField(label, value, () => {}, { id });
  const input = field.element as HTMLInputElement;
  const go = (): void => { const text = input.value.trim(); close(); if (text) run(text); };
  input.addEventListener('keydown', (event) => { if (event.key === 'Enter') { event.preventDefault(); go(); } });
  const close = openDialog({ title, class: 'small',
    body: h('div', { class: 'stack' }, h('label', { for: id }, label), input),
    actions: [button('Cancel', () => close()), button(act, go, { look: 'main' })] });
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
    const wait = (): void => { timer = window.setTimeout(away, 4000 + 60 * text.length); };
    message.addEventListener('pointerenter', () => clearTimeout(timer));
    message.addEventListener('pointerleave', wait);
    message.addEventListener('focusin', () => clearTimeout(timer));
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
