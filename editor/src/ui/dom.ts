// Elements without a framework: h() makes them, live() keeps a place of the page in step with what the store says.

import type { Store, State } from '../store';

export type Child = Node | string | number | null | undefined | false | Child[];
type Handler = (event: any) => void;
/** Attributes; `on…` are listeners, `class` and `style` are text, true and false set or leave out an attribute.
    Styles are set by script, since the page's policy allows no style attributes. */
export type Props = { [name: string]: string | number | boolean | null | undefined | Handler };

/** Makes an element with attributes, listeners and children. */
export function h<K extends keyof HTMLElementTagNameMap>(tag: K, props?: Props | null, ...children: Child[]):
  HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  setProps(element, props);
  append(element, children);
  return element;
}

/** The same for SVG. */
export function svg<K extends keyof SVGElementTagNameMap>(tag: K, props?: Props | null, ...children: Child[]):
  SVGElementTagNameMap[K] {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  setProps(element, props);
  append(element, children);
  return element;
}

function setProps(element: Element, props?: Props | null): void {
  for (const [name, value] of Object.entries(props ?? {})) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value);
    else if (name === 'style') (element as HTMLElement).style.cssText = String(value ?? '');
    else set(element, name, value);
  }
}

/** Sets an attribute, or takes it away: null, undefined and false. ARIA's false is the word. */
export function set(element: Element, name: string, value: string | number | boolean | null | undefined): void {
  if (name.startsWith('aria-') && typeof value === 'boolean') element.setAttribute(name, String(value));
  else if (value === null || value === undefined || value === false) element.removeAttribute(name);
  else element.setAttribute(name, value === true ? '' : String(value));
}

function append(parent: Node, children: Child[]): void {
  for (const child of children) {
    if (Array.isArray(child)) append(parent, child);
    else if (child instanceof Node) parent.appendChild(child);
    else if (child !== null && child !== undefined && child !== false) {
      parent.appendChild(document.createTextNode(String(child)));
    }
  }
}

/** Puts other children into a host; what had the focus, told by its `data-key`, gets it again. */
export function fill(host: Element, ...children: Child[]): void {
  const focused = host.contains(document.activeElement) ? document.activeElement as HTMLElement : null;
  const key = focused?.dataset.key;
  const fragment = document.createDocumentFragment();
  append(fragment, children);
  host.replaceChildren(fragment);
  if (key === undefined) return;
  const again = host.querySelector<HTMLElement>(`[data-key="${CSS.escape(key)}"]`) ?? firstFocusable(host);
  again?.focus({ preventScroll: true });
}

const focusable = 'button:not([disabled]), input:not([disabled]), select:not([disabled]), textarea:not([disabled]), ' +
  'a[href], [tabindex]:not([tabindex="-1"])';

/** What the keyboard can reach inside a host, in order. */
export function focusables(host: Element): HTMLElement[] {
  return [...host.querySelectorAll<HTMLElement>(focusable)].filter((element) => element.offsetParent !== null);
}

function firstFocusable(host: Element): HTMLElement | undefined { return focusables(host)[0]; }

/** A control marks itself while a hand is on it, so that nobody takes it away under the hand. */
export function hold(element: HTMLElement, on: boolean): void {
  if (on) element.dataset.held = '';
  else {
    delete element.dataset.held;
    element.dispatchEvent(new CustomEvent('released', { bubbles: true }));
  }
}

/** Builds a host's children from what `read` gives, and again whenever that changes; `read` gives plain JSON and is
    asked after the keys of the store have changed. Waits while a control inside is held. Returns the way to ask at
    once, for what `read` knows beside the store. */
export function live<T>(store: Store, host: HTMLElement, keys: (keyof State)[], read: (state: State) => T,
  build: (value: T) => Child): () => void {
  let shown: string | undefined;
  const refresh = (): void => {
    if (host.querySelector('[data-held]')) return;
    const value = read(store.state);
    const text = JSON.stringify(value) ?? '';
    if (text === shown) return;
    shown = text;
    fill(host, build(value));
  };
  host.addEventListener('released', () => queueMicrotask(refresh));
  refresh();
  store.on(keys, refresh);
  return refresh;
}

let serial = 0;
/** An id that no other element has. */
export function uid(): string { return `u${++serial}`; }

/** Something kept for the next visit; browsers may refuse to. */
export function remember(key: string, value: string): void {
  try { localStorage.setItem(`pith.${key}`, value); } catch { /* private windows keep nothing,
    which is their promise */ }
}

/** What was kept, or null. */
export function recall(key: string): string | null {
  try { return localStorage.getItem(`pith.${key}`); } catch { return null; }
}
