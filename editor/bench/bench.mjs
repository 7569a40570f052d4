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
  await measureModel('kiwi', kiwi);
  if (!process.env.SMALL) await measureModel('200 000 tetrahedra', large);
  const [cpu] = cpus();
  const result = { bench: 'editor', machine: { cpu: cpu.model, cores: cpus().length, load: loadavg()[0], browser: 'chromium, software rendering' }, cases };
  if (process.argv.includes('--json')) console.log(JSON.stringify(result, null, 1));
} finally {
  await closeBrowser();
  rmSync(folder, { recursive: true, force: true });
}
