// The line at the bottom: what the tool does, what there is, how long it took, and whether the server is there.

import { h } from '../ui/dom';
import { count, many, seconds } from '../ui/numbers';
import type { Context } from './context';
import { stageTimes } from './topbar';

/** Builds the line. */
export function statusbar({ app }: Context): HTMLElement {
  const { store, model } = app;
  const hint = h('span', { class: 'status-hint' }), facts = h('span', { class: 'status-facts' });
  const link = h('span', { class: 'status-link', role: 'status' }, h('span', { class: 'dot', 'aria-hidden': 'true' }),
    h('span'));
  let built = '';
  const refresh = (): void => {
    const { hint: text, connection } = store.state;
    hint.textContent = text;
    hint.title = text;
    const parts = [];
    if (model.triangles > 0) parts.push(many(model.triangles, 'triangle'));
    if (model.patches() > 0) parts.push(`${count(model.patches())} patches`);
    if (model.seconds.cut !== undefined) parts.push(`cut ${seconds(model.seconds.cut)}`);
    if (built) parts.push(built);
    facts.textContent = parts.join('  ·  ');
    link.dataset.state = connection;
    link.lastElementChild!.textContent = { connecting: 'Connecting', open: 'Connected', lost: 'Lost',
      gone: 'Not running', refused: 'Closed' }[connection];
  };
  store.on(['hint', 'serial', 'connection'], refresh);
  store.on(['jobs'], () => {
    const job = store.state.jobs.find((each) => each.state === 'done'
      && (each.what === 'solid' || each.what === 'fields'));
    if (!job) return;
    built = `built in ${seconds(job.seconds ?? 0)}`;
    facts.dataset.tip = stageTimes(job.times);
    refresh();
  });
  refresh();
  return h('footer', { class: 'statusbar' }, hint, facts, link);
}
