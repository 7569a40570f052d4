// The page begins here.

import { Actions } from './actions';
import { Timing, type App } from './app';
import { Connection } from './connection';
import { Model } from './model';
import { installAskedColours } from './asked';
import { buildPage } from './panels/page';
import type { BodyState, DocumentEvent, Hello, JobEvent, SurfacesEvent, ViewState } from './protocol';
import { sentence } from './sentences';
import { Store } from './store';
import { installFieldView } from './fieldview';
import { cutTool } from './tools/cut';
import { depthTool, directionTool, pointsTool } from './tools/draw';
import { installMarks } from './tools/marks';
import { faceTool, fillTool } from './tools/paint';
import { pasteTool, scaleTool } from './tools/place';
import { planeTool } from './tools/plane';
import { selectTool } from './tools/select';
import { eraseSurfaceTool, paintSurfaceTool } from './tools/surface';
import { installSurfaceView } from './surfaceview';
import { Toolbox } from './tools/toolbox';
import { Messages } from './ui/dialog';
import { Viewport } from './view/viewport';
import { installVolumeView } from './volume';

const token = location.hash.slice(1);
const store = new Store();
const connection = new Connection(token);
const viewport = new Viewport();
const actions = new Actions(connection, store);
const toolbox = new Toolbox(store, viewport);
const calm = matchMedia('(prefers-reduced-motion: reduce)');

let together = 1, moving = 0;
const app: App = {
  store, connection, actions, viewport, toolbox, model: new Model(connection), messages: new Messages(), timing: new Timing(),
  assemble(on) {
    const from = together, to = on ? 0 : 1, start = performance.now();
    cancelAnimationFrame(moving);
    const step = (now: number) => {
      const part = calm.matches ? 1 : Math.min(1, (now - start) / 180);
      together = from + (to - from) * part * (2 - part);
      viewport.arrange(together, together * store.state.apart * 0.5 * viewport.diagonal);
      if (part < 1) moving = requestAnimationFrame(step);
    };
    step(start);
  },
};

/* The packets of the view follow a document closely, and its panels take longer to lay out than a cut takes: they wait. */
const panelsWait = 40;

function takeDocument(event: Omit<DocumentEvent, 'event'>): void {
  const { revision, document, name, undo, redo, saved, recovered, bodies, view } = event;
  store.set({ revision, document, name, undo, redo, saved, recovered, bodies, body: Math.min(store.state.body, Math.max(0, bodies.length - 1)) },
            panelsWait);
  takeViewState(view);
  showStale(bodies);
  const render = document.render ?? {};
  viewport.light(render.light_azimuth ?? -50, render.light_elevation ?? 48);
}

function takeViewState(view: ViewState | undefined): void {
  store.set({ viewWhy: view?.why ? sentence(view.why) : null }, panelsWait);
}

/* What is built of the bodies; those that show another solid than the document's are drawn paler. */
function takeBodies({ bodies, view }: { bodies: BodyState[]; view?: ViewState }): void {
  store.set({ bodies }, panelsWait);
  takeViewState(view);
  showStale(bodies);
}

function showStale(bodies: BodyState[]): void {
  viewport.stale(new Set(bodies.flatMap((body, i) => (body.shown ? [] : [i]))));
}

function takeSurfaces(event: SurfacesEvent): void {
  viewport.listSurfaces(event);
  const why = event.bodies.find((body) => body.why)?.why;
  store.set({ surfacesWhy: why ? sentence(why) : null, serial: store.state.serial + 1 });
}

function takeJob(event: JobEvent): void {
  const others = store.state.jobs.filter((job) => job.job !== event.job && (job.state === 'waiting' || job.state === 'running'));
  store.set({ jobs: [...others, event] });
}

async function hello(): Promise<void> {
  const answer = await connection.ask<Hello>('hello');
  const { version, path, file, socket, automatic, schema, types, functions = {}, templates } = answer;
  viewport.stateCamera(answer.document.camera);
  store.set({ connection: 'open', version, path, file, socket, automatic, schema, types, functions, templates });
  takeDocument(answer);
}

connection.onState = (state) => {
  store.set({ connection: state === 'open' ? store.state.connection : state });
  if (state === 'open') hello().catch((reason) => actions.complain(String(reason.message ?? reason)));
};
connection.onEvent = (event) => {
  if (event.event === 'document') takeDocument(event);
  else if (event.event === 'job') takeJob(event);
  else if (event.event === 'bodies') takeBodies(event);
  else if (event.event === 'surfaces') takeSurfaces(event);
  else if (event.event === 'automatic') store.set({ automatic: event.on });
  else if (event.event === 'note') actions.complain(event.message);
};
connection.onPacket = (packet) => {
  if (packet.kind === 'view') app.timing.view(packet.bytes, packet.head.seconds ?? {});
  app.model.take(packet);
  if (viewport.take(packet)) store.set({ serial: store.state.serial + 1 });
};
viewport.onDraw.push(() => app.timing.drawn());
viewport.onView.push(() => {
  viewport.arrange(together, together * store.state.apart * 0.5 * viewport.diagonal);
  if (store.state.part !== null && store.state.part >= viewport.view!.parts.length) store.set({ part: null });
  viewport.pick(store.state.part);
});
store.on(['apart'], () => viewport.arrange(together, together * store.state.apart * 0.5 * viewport.diagonal));
store.on(['part'], () => viewport.pick(store.state.part));
store.on(['mode'], () => viewport.look({ mode: { solid: 0, volume: 0, surfaces: 0, depth: 1, shape: 2 }[store.state.mode] }));
store.on(['isolines'], () => viewport.look({ isolines: store.state.isolines }));

toolbox.add(selectTool(app), cutTool(app), planeTool(app), fillTool(app), faceTool(app), depthTool(app), pointsTool(app),
            directionTool(app), scaleTool(app), pasteTool(app),
            paintSurfaceTool(app), eraseSurfaceTool(app));
const { commands, sketch } = buildPage(app);
installFieldView(app);
installSurfaceView(app);
installMarks(app);
installVolumeView(app);
const asked = installAskedColours(app);
toolbox.enter();
(globalThis as any).pith = Object.assign(app, { commands, asked, sketch }); // for tests, benchmarks, and the curious
