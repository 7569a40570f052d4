// The sketching mode: tools, a pane along the axis, a pane across it, as wide and as high as one likes.

import type { Context } from '../panels/context';
import { labelled } from '../panels/tooloptions';
import { fileDialog } from '../dialogs/pick';
import { upload } from '../dialogs/files';
import { button, iconButton, rove, segmented } from '../ui/controls';
import { fill, h, recall, remember, set, type Child } from '../ui/dom';
import { icon } from '../ui/icons';
import { splitter } from '../ui/layout';
import { slider } from '../ui/slider';
import { bodyJson, chosenSurface } from '../store';
import { sketchPath, type PaneName } from './drawn';
import { eraseSide, paneTools } from './tools';
import { removeKnot, smoothAll, toggleCorner } from './editing';
import { Pane } from './pane';
import type { Session } from './session';
import { startCard } from './start';
import type { PaneTool } from './tool';

const titles: { [pane in PaneName]: string } = { vertical: 'Along the axis', horizontal: 'Across the axis' };

export class Workspace {
  readonly element: HTMLElement;
  readonly edge: HTMLElement;
  readonly panes: { [pane in PaneName]: Pane };
  readonly tools: PaneTool[];
  private entered: PaneTool;

  constructor(private readonly context: Context, readonly session: Session) {
    const { app } = context;
    this.tools = paneTools(session);
    this.entered = this.tool;
    this.panes = { vertical: new Pane(app, session, 'vertical'), horizontal: new Pane(app, session, 'horizontal') };
    for (const pane of Object.values(this.panes)) {
      pane.tool = () => this.tool;
      pane.canvas.addEventListener('keydown', (event) => this.key(event, pane));
    }
    const upper = this.framed('vertical'), lower = this.framed('horizontal');
    let share = Number(recall('sketch.share')) || 0.54, width = Number(recall('sketch.width')) || 0;
    const divide = (next: number): void => {
      share = Math.min(0.85, Math.max(0.15, next));
      upper.style.flexGrow = String(share);
      lower.style.flexGrow = String(1 - share);
      remember('sketch.share', String(share));
    };
    const between = splitter('Height of the panes', () => Math.round(upper.clientHeight), (next) =>
      divide(next / (upper.clientHeight + lower.clientHeight || 1)), [80, 4000], 'below');
    this.element = h('section', { class: 'sketch', 'aria-label': 'Sketch' }, this.toolbar(), this.options(),
      h('div', { class: 'panes' }, upper, between, lower), startCard(context));
    this.edge = splitter('Width of the sketch', () => width || this.element.clientWidth, (next) => {
      width = next;
      this.element.style.setProperty('--sketch-width', `${width}px`);
      remember('sketch.width', String(width));
    }, [260, 1600], 'right of');
    if (width > 0) this.element.style.setProperty('--sketch-width', `${width}px`);
    divide(share);
    const refresh = (): void => {
      this.element.hidden = this.edge.hidden = !app.store.state.sketching;
      if (app.store.state.sketching) app.store.set({ tab: 'sketch', hint: this.tool.hint });
      else app.store.set({ hint: app.toolbox.current?.hint ?? '' });
    };
    app.store.on(['sketching'], () => {
      refresh();
      // The view has another shape now; the model is to be seen whole in it, unless a hand has placed it.
      if (!app.viewport.touched) requestAnimationFrame(() => requestAnimationFrame(() => app.viewport.table.frame()));
    });
    refresh();
  }

  get tool(): PaneTool { return this.tools.find((tool) => tool.name === this.session.values.tool)!; }

  /** Takes up a tool. */
  take(tool: PaneTool): void {
    if (tool === this.entered) return;
    this.entered.cancel?.();
    this.entered = tool;
    this.session.set({ tool: tool.name });
    this.context.app.store.set({ hint: tool.hint });
    for (const pane of Object.values(this.panes)) pane.canvas.style.cursor = tool.cursor ?? '';
  }

  /* Letters are the panes' own while one of them has the focus; what they do not use is the page's. */
  private key(event: KeyboardEvent, pane: Pane): void {
    const done = (): void => { event.preventDefault(); event.stopPropagation(); };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === 'Escape') {
      const busy = pane.giveUp(), had = this.tool.cancel?.();
      if (!busy && !had && this.context.app.store.state.selectedSurface !== null) this.context.app.store.set({ selectedSurface: null });
      return done();
    }
    if (this.tool.keys?.(event, pane)) return done();
    if (event.key === 'f') { pane.frame(); return done(); }
    const tool = this.tools.find((each) => each.key === event.key.toLowerCase() && !event.shiftKey);
    if (!tool) return;
    this.take(tool);
    done();
  }

  /* ---- tools ---- */

  private toolbar(): HTMLElement {
    const buttons = this.tools.map((tool) => h('button', { type: 'button', role: 'radio', class: 'tool', 'aria-label': tool.label,
      'data-tip': `${tool.label}: ${tool.hint.charAt(0).toLowerCase()}${tool.hint.slice(1)}`, 'data-tip-keys': tool.key.toUpperCase(),
      'data-key': `sketch ${tool.name}`, onclick: () => this.take(tool) }, icon(tool.icon, 20)));
    const refresh = (): void => this.tools.forEach((tool, i) => {
      set(buttons[i], 'aria-checked', tool === this.tool);
      buttons[i].tabIndex = tool === this.tool ? 0 : -1;
    });
    this.session.on(refresh);
    refresh();
    const group = h('div', { class: 'sketch-tools', role: 'radiogroup', 'aria-label': 'Sketching tools' }, buttons);
    group.addEventListener('keydown', (event) => rove(event, buttons));
    return h('div', { class: 'sketch-bar' }, group,
      iconButton('close', 'Leave the sketch', () => this.context.app.store.set({ sketching: false }), { look: 'plain',
        keys: this.context.commands.get('sketch').keys[0] }));
  }

  /* What the tool can be told; built anew only when that is another thing. */
  private options(): HTMLElement {
    const bar = h('div', { class: 'sketch-options', role: 'toolbar', 'aria-label': 'Options of the sketching tool' });
    let shown = '';
    const refresh = (): void => {
      const { store } = this.context.app, { tool, knot, cut, redraw } = this.session.values;
      const curve = knot && this.session.curve(knot.curve);
      const now = JSON.stringify([tool, knot, curve?.knots[knot!.index]?.corner, cut && [cut.surface, cut.pane], redraw,
        store.state.selectedSurface, store.state.paintColour, bodyJson(store.state).sketch, tool === 'bend' && this.session.values.reach]);
      if (now === shown || bar.querySelector('[data-held]')) return;
      shown = now;
      fill(bar, this.optionsOf());
    };
    this.session.on(refresh);
    this.context.app.store.on(['paintColour'], refresh);
    refresh();
    return bar;
  }

  private optionsOf(): Child {
    const { session, context: { app } } = this, { tool, redraw, knot, reach, brush, smoothing, cut } = session.values;
    const chosen = chosenSurface(app.store.state)?.json;
    const whose = h('span', { class: 'sketch-whose' }, chosen ? `${chosen.name}` : 'No surface chosen');
    const amount = (): HTMLElement => labelled('Strength', slider('Strength of smoothing', { min: 0, max: 1, default: 0.5 }, smoothing,
      (value) => session.set({ smoothing: value }), { key: 'sketch smoothing' }).element);
    switch (tool) {
      case 'draw': {
        const grains = chosen?.kind === 'grains', able = grains || chosen?.vertical !== undefined;
        const choices = [{ value: 'new', label: 'New surface', tip: 'A curve along the axis becomes a new surface' },
          { value: 'redraw', label: chosen ? `${grains ? 'Strew' : 'Redraw'} ${chosen.name}` : 'Redraw', disabled: !able,
            tip: grains ? 'A stroke along the axis, over the surface that they lie on, says where they are strewn'
              : 'A curve along the axis replaces that of the chosen surface' }];
        return [segmented('What a curve along the axis becomes', choices, redraw && able ? 'redraw' : 'new',
          (value) => session.set({ redraw: value === 'redraw' }), { key: 'sketch draw' }).element,
        h('span', { class: 'quiet' }, chosen?.vertical ? `Across: the loop of ${chosen.name}` : '')];
      }
      case 'edit': {
        const curve = knot && session.curve(knot.curve), pane = curve && this.panes[curve.pane];
        if (!knot || !curve || !pane) return [whose, button('Smooth', () => smoothAll(session), { icon: 'smooth', key: 'sketch smooth all' })];
        return [whose, button(curve.knots[knot.index].corner ? 'Round' : 'Corner', () => toggleCorner(session, pane, curve, knot.index),
          { icon: 'corner', keys: 'C', key: 'sketch corner' }),
        button('Delete point', () => removeKnot(session, pane, curve, knot.index), { icon: 'trash', keys: 'Delete', key: 'sketch delete' })];
      }
      case 'bend': {
        const longest = Math.max(...session.curves.map(({ spline }) => spline.length), 1e-6);
        return [whose, labelled('Reach', slider('Reach', { min: 0, max: 1e9, soft: [0, Number((longest / 2).toPrecision(2))] },
          reach || Number((longest / 4).toPrecision(2)),
          (value) => session.set({ reach: value }), { key: 'sketch reach' }).element)];
      }
      case 'smooth': return [amount(), labelled('Brush', slider('Width of the brush', { min: 6, max: 120, whole: true, default: 28, unit: 'px' },
        brush, (value) => session.set({ brush: value }), { key: 'sketch brush' }).element),
      button('Smooth all', () => smoothAll(session), { tip: 'Smooth all curves of the chosen surface', key: 'sketch smooth all' })];
      case 'erase': {
        if (!cut) return [whose, h('span', { class: 'quiet' }, 'Draw a stroke across it')];
        const sides = cut.closed ? ['Inside', 'Outside'] : ['Left side', 'Right side'];
        return [h('span', { class: 'sketch-whose' }, `From ${cut.surface} erase`),
          sides.map((side, i) => button(side, () => eraseSide(session, i === 1), { key: `sketch side ${i}` }))];
      }
      case 'pick': return [h('span', { class: 'sketch-swatch', style: `--colour: ${app.store.state.paintColour}`, role: 'img',
        'aria-label': `Colour to paint with, ${app.store.state.paintColour}` }), h('span', { class: 'sketch-whose' }, app.store.state.paintColour),
      chosen && button(`Colour ${chosen.name}`, () => void session.apply(`Colour ${chosen.name}`,
        [{ op: 'set', path: `${chosenSurface(app.store.state)!.place}.colours.front`, value: app.store.state.paintColour }]),
      { icon: 'drop', tip: 'The front of the chosen surface takes this colour', key: 'sketch colour' })];
      case 'picture': return Object.values(this.panes).map(({ name }) => this.pictureButtons(name));
    }
  }

  /* ---- panes ---- */

  private pictureButtons(name: PaneName): Child {
    const { session } = this, there = session.pictures[name].json !== null;
    return h('div', { class: 'option' }, h('span', { class: 'option-label' }, titles[name]),
      button(there ? 'Replace…' : 'Load…', () => this.choosePicture(name), { key: `sketch load ${name}` }),
      there && iconButton('trash', `Take the picture away: ${titles[name].toLowerCase()}`, () => void session.apply('Take the picture away',
        [{ op: 'remove', path: `${sketchPath(this.context.app.store.state)}.${name}` }]), { look: 'plain', key: `sketch unload ${name}` }));
  }

  private choosePicture(name: PaneName): void {
    fileDialog(this.context.app, 'image', (path) => void this.usePicture(name, path));
  }

  /* A new picture lies where the old one did, or as large as what is seen. */
  private async usePicture(name: PaneName, image: string): Promise<void> {
    const { session } = this, pane = this.panes[name], before = session.pictures[name].json;
    const round = (value: number): number => Number(value.toPrecision(3));
    const fresh = { image, x: 0, y: round(name === 'vertical' ? pane.middle[1] : 0), width: round((0.6 * Math.min(pane.width, pane.height)) / pane.zoom) };
    if (await session.apply('Load a picture', [{ op: 'set', path: `${sketchPath(this.context.app.store.state)}.${name}`,
      value: before ? { ...before, image } : fresh }])) {
      this.take(this.tools.find((tool) => tool.name === 'picture')!);
    }
  }

  private framed(name: PaneName): HTMLElement {
    const { session } = this, pane = this.panes[name], why = h('p', { class: 'pane-why', role: 'status' });
    const opacity = h('input', { type: 'range', class: 'track pane-opacity', min: 0, max: 100, 'aria-label': `Opacity of the picture: ${titles[name].toLowerCase()}`,
      'data-tip': 'How strongly the picture shows', oninput: () => show() });
    const show = (): void => {
      session.opacity(name, Number(opacity.value) / 100);
      opacity.style.setProperty('--at', String(Number(opacity.value) / 100));
    };
    opacity.value = String(Math.round(100 * session.opacity(name)));
    opacity.style.setProperty('--at', String(session.opacity(name)));
    const load = iconButton('image', `Picture: ${titles[name].toLowerCase()}`, () => this.choosePicture(name), { look: 'plain', key: `pane picture ${name}` });
    const refresh = (): void => {
      const picture = session.pictures[name];
      void picture.image;             // asks for it when it is not here yet
      opacity.hidden = !picture.json;
      why.textContent = picture.why;
      why.hidden = picture.why === null;
    };
    session.on(refresh);
    this.context.app.store.on(['connection'], refresh);
    refresh();
    const element = h('div', { class: 'pane', 'data-pane': name }, pane.canvas,
      h('div', { class: 'pane-head' }, h('h3', null, titles[name]), opacity, load,
        iconButton('frame', `Show everything: ${titles[name].toLowerCase()}`, () => pane.frame(), { look: 'plain', keys: 'F' })), why);
    this.takeDrops(element, name);
    return element;
  }

  /* A picture dropped on a pane is put beside the document and laid into the pane. */
  private takeDrops(element: HTMLElement, name: PaneName): void {
    element.addEventListener('dragover', (event) => { event.preventDefault(); element.classList.add('over'); });
    element.addEventListener('dragleave', () => element.classList.remove('over'));
    element.addEventListener('drop', async (event) => {
      event.preventDefault();
      event.stopPropagation();
      element.classList.remove('over');
      const file = event.dataTransfer?.files[0], path = file && await upload(this.context.app, file);
      if (path && /\.(png|jpe?g)$/i.test(path)) await this.usePicture(name, path);
      else if (path) this.context.app.messages.say(`${path} is beside the document now; it is no picture.`);
    });
  }
}
