// What floats over the page beside something: tooltips, menus and small panels.

import { focusables, h, set, uid } from './dom';
import { icon, type IconName } from './icons';
import { rove } from './controls';

type Side = 'below' | 'right' | 'above';

/** Puts an element beside an anchor, inside the window; the other side when there is no room. */
export function place(element: HTMLElement, anchor: DOMRect, side: Side): void {
  const own = element.getBoundingClientRect(), gap = 6, margin = 8;
  const wide = window.innerWidth, high = window.innerHeight;
  let x = anchor.left + anchor.width / 2 - own.width / 2, y = anchor.bottom + gap;
  if (side === 'right') { x = anchor.right + gap; y = anchor.top + anchor.height / 2 - own.height / 2; }
  if (side === 'right' && x + own.width > wide - margin) x = anchor.left - gap - own.width;
  if (side === 'above' || (side === 'below' && y + own.height > high - margin)) y = anchor.top - gap - own.height;
  if (y < margin && side !== 'right') y = anchor.bottom + gap;
  element.style.left = `${Math.max(margin, Math.min(x, wide - own.width - margin))}px`;
  element.style.top = `${Math.max(margin, Math.min(y, high - own.height - margin))}px`;
}

/** Shows what `data-tip` says, with the shortcut of `data-tip-keys`, for whatever is pointed at or has the focus. */
export function installTooltips(): void {
  const text = h('span'), keys = h('kbd');
  const tip = h('div', { class: 'tooltip', role: 'tooltip', id: uid(), hidden: true }, text, keys);
  document.body.append(tip);
  let target: HTMLElement | null = null, timer = 0, lately = 0;

  const hide = (): void => {
    clearTimeout(timer);
    if (!tip.hidden) lately = performance.now();
    tip.hidden = true;
    if (target?.getAttribute('aria-describedby') === tip.id) target.removeAttribute('aria-describedby');
    target = null;
  };
  const show = (): void => {
    if (!target?.isConnected) return hide();
    text.textContent = target.dataset.tip ?? '';
    keys.textContent = target.dataset.tipKeys ? shortcut(target.dataset.tipKeys) : '';
    keys.hidden = !keys.textContent;
    const topmost = target.closest('dialog') ?? document.body;
    if (tip.parentNode !== topmost) topmost.append(tip);
    tip.hidden = false;
    if (!target.hasAttribute('aria-describedby')) set(target, 'aria-describedby', tip.id);
    place(tip, target.getBoundingClientRect(), target.closest('[data-tips=right]') ? 'right' : 'below');
  };
  const want = (event: Event): void => {
    const found = (event.target as Element).closest?.<HTMLElement>('[data-tip]') ?? null;
    if (found === target) return;
    hide();
    if (!found || (event instanceof PointerEvent && event.pointerType === 'touch')) return;
    if (event.type === 'focusin' && !found.matches(':focus-visible')) return;
    target = found;
    timer = window.setTimeout(show, performance.now() - lately < 300 ? 60 : 550);
  };
  document.addEventListener('pointerover', want);
  document.addEventListener('focusin', want);
  document.addEventListener('focusout', hide);
  document.addEventListener('pointerdown', hide, true);
  document.addEventListener('keydown', (event) => { if (event.key === 'Escape' || !tip.hidden) hide(); }, true);
  document.addEventListener('scroll', hide, true);
}

const apple = /Mac|iP(hone|ad)/.test(navigator.platform);

/** A shortcut as this machine's keyboard names it. */
export function shortcut(keys: string): string {
  if (!apple) return keys;
  return keys.replace(/Ctrl\+/g, '⌘').replace(/Shift\+/g, '⇧').replace(/Alt\+/g, '⌥');
}

/** Opens an element beside an anchor until Escape, a click elsewhere or `close`; gives the focus back then. */
export function popup(anchor: HTMLElement, element: HTMLElement, side: Side = 'below'): () => void {
  const before = document.activeElement as HTMLElement | null;
  const topmost = anchor.closest('dialog') ?? document.body;
  topmost.append(element);
  place(element, anchor.getBoundingClientRect(), side);
  set(anchor, 'aria-expanded', true);
  const close = (): void => {
    document.removeEventListener('pointerdown', outside, true);
    window.removeEventListener('resize', close);
    set(anchor, 'aria-expanded', false);
    const inside = element.contains(document.activeElement);
    element.remove();
    if (inside) (anchor.isConnected ? anchor : before)?.focus();
  };
  const outside = (event: Event): void => {
    const at = event.target as Node;
    if (!element.contains(at) && !anchor.contains(at)) close();
  };
  element.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape') return;
    event.stopPropagation();
    close();
  });
  element.addEventListener('focusout', (event) => {
    const next = event.relatedTarget as Node | null;
    if (next && !element.contains(next) && !anchor.contains(next)) close();
  });
  document.addEventListener('pointerdown', outside, true);
  window.addEventListener('resize', close);
  focusables(element)[0]?.focus({ preventScroll: true });
  return close;
}

export interface MenuItem { label: string; run: () =>
  void; icon?: IconName; keys?: string; disabled?: boolean; danger?: boolean }

/** A button's menu: opens on a click, arrow keys go through it. `null` among the items draws a line. */
export function menuButton(anchor: HTMLButtonElement, items: () => (MenuItem | null)[]): HTMLButtonElement {
  let close: (() => void) | null = null;
  set(anchor, 'aria-haspopup', 'menu');
  set(anchor, 'aria-expanded', false);
  anchor.addEventListener('click', () => {
    if (close && anchor.getAttribute('aria-expanded') === 'true') return close();
    const buttons: HTMLButtonElement[] = [];
    const list = h('div', { class: 'menu', role: 'menu', 'aria-label': anchor.ariaLabel ?? anchor.textContent },
      items().map((item) => {
        if (!item) return h('hr', { role: 'separator' });
        const entry = h('button', { type: 'button', role: 'menuitem', class: item.danger ? 'danger' : '',
          disabled: item.disabled, onclick: () => { close?.(); item.run(); } },
        item.icon ? icon(item.icon, 16) : h('span', { class: 'no-icon' }), h('span', null, item.label),
        item.keys && h('kbd', null, shortcut(item.keys)));
        if (!item.disabled) buttons.push(entry);
        return entry;
      }));
    list.addEventListener('keydown', (event) => rove(event, buttons, false));
    close = popup(anchor, list);
  });
  return anchor;
}
