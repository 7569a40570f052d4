// Buttons and the fields of plain values. Every one has a name for screen readers and a place for the keyboard.

import { h, set, uid, type Child } from './dom';
import { icon, type IconName } from './icons';

/** A field of one value; `set` shows another without telling anybody. */
export interface Control<T> { element: HTMLElement; set(value: T): void }

export interface ButtonLook {
  icon?: IconName;
  /** 'plain' has no border until it is pointed at; 'main' is the one thing to do; 'danger' takes away. */
  look?: 'plain' | 'main' | 'danger';
  tip?: string;
  keys?: string;                    // its shortcut, shown in the tooltip
  key?: string;                     // finds it again after its place was built anew
  disabled?: boolean;
  class?: string;
}

/** A button with a word, and perhaps an icon before it. */
export function button(label: Child, run: (event: MouseEvent) => void, look: ButtonLook = {}): HTMLButtonElement {
  return h('button', {
    type: 'button', class: `button ${look.look ?? ''} ${look.class ?? ''}`, onclick: run, disabled: look.disabled,
    'data-tip': look.tip, 'data-tip-keys': look.keys, 'data-key': look.key,
  }, look.icon && icon(look.icon, 18), label && h('span', { class: 'button-label' }, label));
}

/** A button that shows an icon alone; the label is what screen readers say and the tooltip shows. */
export function iconButton(name: IconName, label: string, run: (event: MouseEvent) => void, look: ButtonLook = {}):
  HTMLButtonElement {
  return h('button', {
    type: 'button', class: `icon-button ${look.look ?? ''} ${look.class ?? ''}`, onclick: run, disabled: look.disabled,
    'aria-label': label, 'data-tip': look.tip ?? label, 'data-tip-keys': look.keys, 'data-key': look.key,
  }, icon(name, 18));
}

export interface Choice<T> { value: T; label: string; icon?: IconName; tip?: string; keys?: string; disabled?: boolean }

/** A few choices side by side, one of them taken; arrow keys go through them. */
export function segmented<T extends string>(name: string, choices: Choice<T>[], value: T, choose: (value: T) => void,
  options: { key?: string; icons?: 'only' } = {}): Control<T> {
  const buttons = choices.map((choice) => h('button', {
    type: 'button', role: 'radio', class: 'segment', 'data-tip': choice.tip ?? (options.icons ? choice.label : null),
    'data-tip-keys': choice.keys, 'aria-label': options.icons ? choice.label : null, disabled: choice.disabled,
    'data-key': options.key && `${options.key}=${choice.value}`,
    onclick: () => { control.set(choice.value); choose(choice.value); },
  }, choice.icon && icon(choice.icon, 18), !options.icons && h('span', null, choice.label)));
  const element = h('div', { class: 'segmented', role: 'radiogroup', 'aria-label': name }, buttons);
  element.addEventListener('keydown', (event) => rove(event, buttons));
  const control: Control<T> = {
    element,
    set(next) {
      const known = choices.some((choice) => choice.value === next);
      buttons.forEach((segment, i) => {
        set(segment, 'aria-checked', choices[i].value === next);
        segment.tabIndex = choices[i].value === next || (!known && i === 0) ? 0 : -1;
      });
    },
  };
  control.set(value);
  return control;
}

/** Arrow keys, Home and End go through buttons of which one can be reached with Tab, and press what they reach. */
export function rove(event: KeyboardEvent, buttons: HTMLElement[], press = true): void {
  const steps: { [key: string]: number } = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
  const at = buttons.indexOf(document.activeElement as HTMLElement);
  let next = -1;
  if (event.key in steps) next = (at + steps[event.key] + buttons.length) % buttons.length;
  else if (event.key === 'Home') next = 0;
  else if (event.key === 'End') next = buttons.length - 1;
  if (at < 0 || next < 0) return;
  event.preventDefault();
  event.stopPropagation();
  for (const each of buttons) each.tabIndex = each === buttons[next] ? 0 : -1;
  buttons[next].focus();
  if (press) buttons[next].click();
}

/** Yes or no. A label of '' is for one that stands in a row; `name` is its name then. */
export function checkbox(label: string, value: boolean, choose: (value: boolean) => void,
  options: { key?: string; tip?: string; look?: 'switch'; name?: string } = {}): Control<boolean> {
  const input = h('input', {
    type: 'checkbox', class: options.look ?? 'check', 'data-key': options.key, role: options.look ? 'switch' : null,
    'aria-label': options.name,
    onchange: () => choose(input.checked),
  });
  input.checked = value;
  const element = h('label', { class: 'check-label', 'data-tip': options.tip }, input,
    label !== '' && h('span', null, label));
  return { element, set(next) { input.checked = next; } };
}

/** One of several choices, in a list that opens. */
export function choice<T extends string>(name: string, choices: Choice<T>[], value: T, choose: (value: T) => void,
  options: { key?: string; id?: string } = {}): Control<T> {
  const select = h('select', {
    class: 'field', id: options.id, 'aria-label': options.id ? null : name, 'data-key': options.key,
    onchange: () => choose(select.value as T),
  }, choices.map((each) => h('option', { value: each.value, disabled: each.disabled }, each.label)));
  select.value = value;
  return { element: h('span', { class: 'select' }, select, icon('down', 14)), set(next) { select.value = next; } };
}

/** A line of text, told when it is finished: Enter or leaving it. Escape brings back what was there. */
export function textField(name: string, value: string, finish: (value: string) => void,
  options: { key?: string; id?: string; hint?: string } = {}): Control<string> {
  let told = value;
  const input = h('input', {
    type: 'text', class: 'field', id: options.id, 'aria-label': options.id ? null : name, 'data-key': options.key,
    spellcheck: 'false', autocomplete: 'off', 'aria-placeholder': options.hint, title: options.hint,
    onchange: () => { if (input.value !== told) { told = input.value; finish(input.value); } },
    onkeydown: (event: KeyboardEvent) => {
      if (event.key === 'Enter') input.blur();
      if (event.key !== 'Escape') return;
      event.stopPropagation();
      input.value = told;
      input.blur();
    },
  });
  input.value = value;
  return { element: input, set(next) { told = next; input.value = next; } };
}

/** A colour: a swatch that opens the browser's picker, and its six digits. */
export function colourField(name: string, value: string, choose: (value: string) => void,
  options: { key?: string; id?: string } = {}): Control<string> {
  const picker = h('input', {
    type: 'color', class: 'swatch', 'aria-label': `${name}, picker`, 'data-key': options.key,
    onchange: () => tell(picker.value),
  });
  const text = textField(`${name}, as #rrggbb`, value, (written) => {
    const digits = /^#?([0-9a-f]{6}|[0-9a-f]{3})$/i.exec(written.trim())?.[1];
    if (!digits) text.set(picker.value);
    else tell(`#${digits.length === 3 ? digits.replace(/./g, '$&$&') : digits}`.toLowerCase());
  }, { key: options.key && `${options.key}#`, id: options.id });
  const control: Control<string> = {
    element: h('span', { class: 'colour' }, picker, text.element),
    set(next) { picker.value = next; text.set(next); },
  };
  const tell = (next: string): void => { control.set(next); choose(next); };
  control.set(value);
  return control;
}

/** A label beside a control; pointing at the label explains. */
export function row(label: string, control: HTMLElement, options: { tip?: string; for?: string; wide?: boolean } = {}):
  HTMLElement {
  const id = uid();
  if (!options.for) {
    const group = control.matches('[role]') ? control : control.querySelector('[role=radiogroup]');
    if (group && !group.hasAttribute('aria-label')) set(group, 'aria-labelledby', id);
  }
  return h('div', { class: options.wide ? 'row wide' : 'row' },
    options.for
      ? h('label', { class: 'row-label', for: options.for, id, 'data-tip': options.tip }, label)
      : h('span', { class: 'row-label', id, 'data-tip': options.tip }, label),
    h('div', { class: 'row-control' }, control));
}
