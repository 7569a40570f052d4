// Measures the editor in a real browser: node bench/bench.mjs [--json]. What the server computes, what the way takes and
// what drawing takes are told apart; drawing is by software here and says nothing about a graphics card.
import { cpus, loadavg } from 'node:os';
import { closeBrowser, drag, drawn, join, openPage, readDocument, rmSync, settled, startServer, viewBox, workFolder, writeFileSync } from '../test/harness.mjs';

const repeats = Number(process.env.REPEATS ?? 7);
const cases = [];

function summary(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return { min: sorted[0], median: sorted[Math.floor(sorted.length / 2)] };
}

function add(name, figures) {
  const rounded = Object.fromEntries(Object.entries(figures).map(([key, value]) => [key, typeof value === 'number' ? Number(value.toPrecision(4)) : value]));
  cases.push({ name, ...rounded });
  if (!process.argv.includes('--json')) console.log(name.padEnd(28), Object.entries(rounded).map(([k, v]) => `${k} ${v}`).join('  '));
}

/* Strokes across the model, each undone again: from the end of the stroke to the section's arrival. */
async function measureCuts(name, page) {
  await page.evaluate(() => globalThis.pith.store.set({ tool: 'cut' }));
  await drawn(page);
  const { width, height } = await viewBox(page), runs = [];
  for (let i = 0; i < repeats + 1; ++i) {
    const lean = (i - repeats / 2) * 0.02 * width;
    const before = await page.evaluate(() => (globalThis.pith.timing.done.cut ?? []).length);
    await drag(page, [[width / 2 - lean, height * 0.14], [width / 2 + 0.03 * width, height * 0.5], [width / 2 + lean, height * 0.97]]);
    await page.waitForFunction((n) => (globalThis.pith.timing.done.cut ?? []).length > n, before, { timeout: 60000, polling: 20 });
    const run = await page.evaluate(() => globalThis.pith.timing.done.cut.at(-1));
    if (i > 0) runs.push(run); // the first is the warm-up
    await page.evaluate(() => globalThis.pith.actions.undo());
    await drawn(page);
  }
  const triangles = await page.evaluate(() => globalThis.pith.viewport.view.kinds.length);
  const arrival = runs.map((run) => run.arrived - run.sent), server = runs.map((run) => 1e3 * (run.server.cut + run.server.pack));
  add(name, {
    arrival_ms: summary(arrival).min, arrival_median_ms: summary(arrival).median, server_ms: summary(server).min,
    cut_ms: summary(runs.map((run) => 1e3 * run.server.cut)).min, pack_ms: summary(runs.map((run) => 1e3 * run.server.pack)).min,
    way_ms: summary(runs.map((run, i) => arrival[i] - server[i])).min, drawing_ms: summary(runs.map((run) => run.drawn - run.arrived)).min,
    megabytes: runs.at(-1).bytes / 1e6, triangles,
  });
}

/* The handler of a pointer's move, from the event to the stroke on the overlay (which is drawn before it returns). */
async function measureStrokes(name, page, tool) {
  await page.evaluate((tool) => globalThis.pith.store.set({ tool, mode: 'solid' }), tool);
  await drawn(page);
  await page.evaluate(() => {
    globalThis.moves = [];
    const element = globalThis.pith.viewport.element;
    let start = 0;
    element.addEventListener('pointermove', () => { start = performance.now(); }, { capture: true });
    element.addEventListener('pointermove', () => globalThis.moves.push(performance.now() - start));
  });
  const { width, height } = await viewBox(page);
  await drag(page, [[width * 0.42, height * 0.4], [width * 0.5, height * 0.5], [width * 0.58, height * 0.46]], { steps: 20 });
  await page.keyboard.press('Escape');
  const moves = await page.evaluate(() => globalThis.moves);
  add(name, { handler_ms: summary(moves).median, slowest_ms: Math.max(...moves), moves: moves.length });
}

/* From the start of `pith edit`, with the opening of a browser's window: until the model is seen (as a bare mesh, when
   nothing is saved), and until its inside is, which has to be built first when nothing is saved. */
async function firstPicture(name, document) {
  const start = performance.now();
  const server = await startServer(document);
  const listening = performance.now() - start;
  const { page, close } = await openPage(server, { built: false });
  await page.waitForFunction(() => globalThis.pith.viewport.view, undefined, { polling: 20 });
  await drawn(page);
  const picture = performance.now() - start;
  await settled(page);
  add(name, { listening_ms: listening, picture_ms: picture, inside_ms: performance.now() - start });
  return { server, page, close };
}

async function measureModel(label, document) {
  const cold = await firstPicture(`${label}: first picture, nothing saved`, document);
  await cold.close();
  await cold.server.stop();
  const warm = await firstPicture(`${label}: first picture`, document);
  await measureCuts(`${label}: cutting stroke`, warm.page);
  await measureStrokes(`${label}: stroke under way`, warm.page, 'cut');
  await measureStrokes(`${label}: brush under way`, warm.page, 'face');
  await warm.close();
  await warm.server.stop();
}

/* A surface of 10 000 vertices, one of two, that colours flow from. */
const walls = { pith: 1, sketch: { folds: 3 },
  surfaces: [{ name: 'skin', kind: 'around', across: 144, along: 70, vertical: [[0, 0.9], [0.7, 0.75], [1, 0], [0.6, -0.8], [0, -0.9]],
    colours: { front: '#c8281e', back: '#e0603c' } },
  { name: 'chambers', kind: 'chambers', vertical: [[0.25, 0], [0.5, 0.5], [0.75, 0], [0.5, -0.5]], colours: { front: '#f0b090', back: '#c89a3c' } }],
  shape: { fruit: { detail: 3 } } };

/* From asking for a change of it to its packet in the page. */
async function measureSurfaces(document) {
  const server = await startServer(document), { page, close } = await openPage(server, { built: false });
  await page.waitForFunction(() => globalThis.pith.viewport.surfaces.shown.length === 2 && globalThis.pith.viewport.view, undefined, { polling: 20 });
  await page.evaluate(() => globalThis.pith.actions.automatic(false));
  await drawn(page);
  const changes = {
    paint: (i) => ({ op: 'surface.paint', surface: 'skin', front: `#20${10 + i}ff`, brush: { points: [[0.9, 0, 0.1 * i - 0.4]], radius: 0.2 } }),
    curve: (i) => ({ op: 'surface.curve', surface: 'skin', points: [[0, 0.9], [0.7 - 0.01 * i, 0.75], [1, 0], [0.6, -0.8], [0, -0.9]] }),
  };
  for (const [name, change] of Object.entries(changes)) {
    const runs = [];
    for (let i = 1; i <= repeats + 1; ++i) {
      const took = await page.evaluate(async (operation) => {
        const { actions, viewport } = globalThis.pith, find = () => viewport.surfaces.find(0, 'skin').key;
        const before = find(), start = performance.now();
        const arrived = new Promise((resolve) => {
          const known = viewport.surfaces.onChange;
          viewport.surfaces.onChange = () => {
            known();
            if (find() === before) return;
            viewport.surfaces.onChange = known;
            resolve(performance.now() - start);
          };
        });
        await actions.apply('Change', [operation]);
        return arrived;
      }, change(i));
      if (i > 1) runs.push(took); // the first is the warm-up
      await drawn(page);
    }
    const vertices = await page.evaluate(() => globalThis.pith.viewport.surfaces.find(0, 'skin').positions.length / 3);
    add(`surfaces: ${name}`, { arrival_ms: summary(runs).min, arrival_median_ms: summary(runs).median, vertices });
  }
  await close();
  await server.stop();
}

async function pageWeight(document) {
  const server = await startServer(document);
  const { page, close } = await openPage(server);
  const sizes = await page.evaluate(() => performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))
    .map((entry) => entry.encodedBodySize));
  add('page', { compressed_kb: sizes.reduce((sum, size) => sum + size, 0) / 1e3, files: sizes.length });
  await close();
  await server.stop();
}

const folder = workFolder();
try {
  const kiwi = join(folder, 'examples', 'kiwi.pith'), large = join(folder, 'examples', 'large.pith');
  const text = readDocument(kiwi);
  delete text.cuts;
  writeFileSync(kiwi, JSON.stringify(text));
  text.shape.fruit.detail = 5;
  text.shape.tets.tetrahedra = 200000;
  writeFileSync(large, JSON.stringify(text));
  await pageWeight(kiwi);
  const within = join(folder, 'examples', 'within.pith');
  writeFileSync(within, JSON.stringify(walls));
  await measureSurfaces(within);
  await measureModel('kiwi', kiwi);
  if (!process.env.SMALL) await measureModel('200 000 tetrahedra', large);
  const [cpu] = cpus();
  const result = { bench: 'editor', machine: { cpu: cpu.model, cores: cpus().length, load: loadavg()[0], browser: 'chromium, software rendering' }, cases };
  if (process.argv.includes('--json')) console.log(JSON.stringify(result, null, 1));
} finally {
  await closeBrowser();
  rmSync(folder, { recursive: true, force: true });
}
