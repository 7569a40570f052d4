// The editor as a person uses it: the real program, a real browser. Each test looks at pixels, at the saved document, or
// at what the command line makes of it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { describe, test } from 'node:test';
import { click, Desk, drag, drawn, existsSync, join, openPage, pixels, program, readDocument, rmSync, settled, startServer, state, viewBox } from './harness.mjs';

let desk;

const open = (name, change, options) => desk.openExample(name, change, options);

const apply = (page, name, operations) => page.evaluate(([name, operations]) => globalThis.pith.actions.apply(name, operations), [name, operations]);
const use = async (page, values) => { await page.evaluate((values) => globalThis.pith.store.set(values), values); await drawn(page); };
const count = (page, key) => page.evaluate((key) => (globalThis.pith.store.state.document[key] ?? []).length, key);

/** Waits until a condition holds for the page's state. The page's policy forbids evaluating text, so it is asked here. */
async function until(page, holds, timeout = 60000) {
  for (const end = Date.now() + timeout; !holds(await state(page));) {
    if (Date.now() > end) throw new Error(`waited ${timeout} ms in vain for ${holds}`);
    await new Promise((resolve) => setTimeout(resolve, 40));
  }
}

/* The view follows the document by a packet of its own: until it has sections, or none. */
async function sectionShown(page, shown) {
  await page.waitForFunction((shown) => globalThis.pith.viewport.view.kinds.includes(1) === shown, shown, { timeout: 60000, polling: 30 });
  await settled(page);
}

describe('the editor', { timeout: 600000 }, () => {
  desk = new Desk();

  test('the section is composed as the library samples it', async () => {
    const paste = (recipe, place) => (text) => { text.solids[0].pastes = [{ exemplar: { recipe: `exemplars/${recipe}` }, ...place }]; };
    const cases = [ // depth as s; s of its own; patches cut to fit; pastes, whose s is their own whatever the fill's is
      ['kiwi.pith'], ['sponge.pith'], ['bricks_fitted.pith'],
      ['kiwi.pith', paste('kiwi.json', { point: [0.3, 0.2, 0.1], up: [0, -1, 0], along: [0, 0, 1], size: 0.9 })],
      ['watermelon.pith', paste('cherry.json', { point: [0.35, 0.035, -0.3], up: [0, -1, 0], along: [0, 0, 1], size: 0.7, mask_radius: 0.5, drop_off: 0 })],
    ];
    for (const [name, change] of cases) {
      const page = await open(name, change);
      await page.evaluate(() => globalThis.pith.viewport.look({ unlit: true }));
      const seen = await page.evaluate(() => {
        const { viewport } = globalThis.pith, { clientWidth: w, clientHeight: h } = viewport.element, list = [];
        for (let y = 0.2; y < 0.8; y += 0.03) for (let x = 0.2; x < 0.8; x += 0.03) {
          const hit = viewport.hit(Math.round(w * x) + 0.5, Math.round(h * y) + 0.5);
          if (hit) list.push({ at: [Math.round(w * x), Math.round(h * y)], point: hit.point.toArray(), kind: hit.kind });
        }
        return list;
      });
      const colours = await pixels(page, seen.map(({ at }) => at));
      const input = seen.map(({ point }) => point.join(' ')).join('\n') + '\n';
      const asked = execFileSync(program, ['sample', desk.server.document], { input, encoding: 'utf8' }).trim().split('\n').map((line) => line.split(/\s+/).map(Number));
      const encode = (x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
      let sum = 0, far = 0;
      seen.forEach((_, i) => {
        const off = Math.max(...[0, 1, 2].map((c) => Math.abs(colours[i][c] - encode(asked[i][c]))));
        sum += off;
        if (!(off <= 24)) ++far;
      });
      // A pixel is an area and a sample a point: at the edge of a seed they differ. Nearly all must agree.
      assert.ok(seen.length > 60, `${name}: ${seen.length} places`);
      assert.ok(sum / seen.length < 6, `${name}: mean difference ${(sum / seen.length).toFixed(2)} of 255`);
      assert.ok(far < 0.06 * seen.length, `${name}: ${far} of ${seen.length} differ by more than 24`);
      await desk.opened.close();
      await desk.server.stop();
    }
  });

  test('a cutting stroke cuts, undo heals, redo cuts again, and the command line agrees', async () => {
    const page = await open('kiwi.pith', (text) => { delete text.cuts; });
    const { width, height } = await viewBox(page), middle = [Math.round(width * 0.5) + 50, Math.round(height / 2)];
    const [skin] = await pixels(page, [middle]);
    await use(page, { tool: 'cut' });
    await drag(page, [[width / 2, height * 0.14], [width / 2 + 10, height / 2], [width / 2, height * 0.97]]);
    await until(page, (s) => s.document.cuts && s.document.cuts.length === 1);
    await sectionShown(page, true);
    const parts = await page.evaluate(() => globalThis.pith.viewport.view.parts.filter((part) => !part.hidden).length);
    assert.equal(parts, 1);
    const sections = await page.evaluate(() => globalThis.pith.viewport.view.kinds.reduce((sum, kind) => sum + kind, 0));
    assert.ok(sections > 100, `${sections} triangles of section`);
    assert.equal(await count(page, 'cuts'), 1);
    const [cut] = await pixels(page, [middle]);
    assert.ok(cut.some((value, c) => Math.abs(value - skin[c]) > 8), `what went away was ${skin} and is ${cut}`);
    await page.keyboard.press('Control+z');
    await until(page, (s) => !s.document.cuts || s.document.cuts.length === 0);
    await sectionShown(page, false);
    const [healed] = await pixels(page, [middle]);
    assert.deepEqual(healed, skin);
    await page.keyboard.press('Control+Shift+z');
    await until(page, (s) => s.document.cuts && s.document.cuts.length === 1);
    await page.keyboard.press('Control+s');
    await until(page, (s) => s.saved);
    assert.equal(readDocument(desk.server.document).cuts.length, 1);
    execFileSync(program, ['validate', desk.server.document]);
    execFileSync(program, ['render', desk.server.document, '-o', join(desk.folder, 'cut.png'), '--width', '80', '--height', '60', '--samples', '1']);
    assert.ok(existsSync(join(desk.folder, 'cut.png')));
  });

  test('paint, stroke, update, fill: a bare mesh gets an inside', async () => {
    const page = await open('kiwi_bunny.pith', (text) => {
      for (const key of ['depth', 'direction', 'solids', 'cuts', 'camera']) delete text[key];
    }, { built: false });
    await page.waitForFunction(() => globalThis.pith.viewport.view);
    await drawn(page);
    await use(page, { tool: 'fill', paint: 0, crease: 180 });
    const { width, height } = await viewBox(page);
    await click(page, width / 2, height / 2);
    await until(page, (s) => s.document.depth && s.document.depth.constraints.length === 1);
    assert.equal((await state(page)).document.depth.constraints[0].depth, 0);
    const painted = await page.evaluate(() => { const p = globalThis.pith.viewport.meshes.get(0).painted; return [p.length, p.filter((depth) => depth === 0).length]; });
    assert.ok(painted[1] > 0.9 * painted[0], `${painted[1]} of ${painted[0]} faces are painted`);
    const core = [[2.6, 2.2, 0.95], [0.2, 3.5, 0.75], [-2.5, 4.9, 0.8]];
    assert.ok(await apply(page, 'Core', [
      { op: 'depth.stroke', points: core, depth: 1 }, { op: 'direction.stroke', points: core },
      { op: 'set', path: 'solids', value: [{ name: 'flesh', kind: 'lapped', type: '1-B', exemplar: { recipe: 'exemplars/kiwi.json' } }] },
    ]));
    await settled(page, 120000);
    await use(page, { tool: 'cut' });
    await drag(page, [[width / 2, height * 0.14], [width / 2, height * 0.97]]);
    await until(page, (s) => s.document.cuts && s.document.cuts.length === 1);
    await sectionShown(page, true);
    await page.evaluate(() => globalThis.pith.viewport.look({ unlit: true }));
    const green = await page.evaluate(async () => {
      const image = await createImageBitmap(await globalThis.pith.viewport.picture());
      const canvas = new OffscreenCanvas(image.width, image.height), brush = canvas.getContext('2d');
      brush.drawImage(image, 0, 0);
      const { data } = brush.getImageData(0, 0, image.width, image.height);
      let found = 0;
      for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 200 && data[i + 1] > data[i] + 20 && data[i + 1] > data[i + 2] + 40) ++found;
      return found / (data.length / 4);
    });
    assert.ok(green >= 0 && green < 1);
  });

  test('what is saved is there again; what was not saved is recovered', async () => {
    const page = await open('kiwi.pith');
    await apply(page, 'Title', [{ op: 'set', path: 'title', value: 'One' }]);
    await page.keyboard.press('Control+s');
    await until(page, (s) => s.saved);
    await apply(page, 'Title', [{ op: 'set', path: 'title', value: 'Two' }]);
    assert.equal(readDocument(desk.server.document).title, 'One');
    await desk.opened.close();
    await desk.server.stop('SIGKILL');
    desk.server = await startServer(desk.server.document);
    desk.opened = await openPage(desk.server);
    const now = await state(desk.opened.page);
    assert.equal(now.document.title, 'Two');
    assert.equal(now.recovered, true);
    assert.equal(now.saved, false);
    await desk.opened.page.keyboard.press('Control+z');
    await until(desk.opened.page, (s) => s.document.title === 'One');
  });

  test('a copy replaces a file only when that is said, and a file that is gone is not reverted to', async () => {
    const page = await open('kiwi.pith'), other = join(desk.folder, 'examples', 'tree.pith'), before = readDocument(other).title;
    await apply(page, 'Title', [{ op: 'set', path: 'title', value: 'One' }]);
    await page.keyboard.press('Control+Shift+S');
    const dialog = page.locator('dialog[open]');
    await dialog.locator('input').fill('tree.pith');
    await page.keyboard.press('Enter');
    await dialog.locator('.objection', { hasText: 'There is a file tree.pith already.' }).waitFor();
    assert.equal(readDocument(other).title, before);
    await dialog.getByText('Replace', { exact: true }).click();
    await page.locator('.message', { hasText: 'Saved tree.pith' }).waitFor();
    assert.equal(readDocument(other).title, 'One');
    assert.equal((await state(page)).saved, false, 'the document itself is not saved by a copy');
    rmSync(desk.server.document);
    await page.keyboard.press('Control+s');
    await dialog.getByText('is not where it was').waitFor();
    assert.deepEqual(await dialog.locator('footer button').allTextContents(), ['Cancel', 'Save anyway']);
    await dialog.getByText('Save anyway', { exact: true }).click();
    await until(page, (s) => s.saved);
    assert.equal(readDocument(desk.server.document).title, 'One');
  });

  test('cuts that keep both sides move pieces a little each, and cuts that leave nothing can be undone', async () => {
    const page = await open('kiwi.pith', (text) => { delete text.cuts; });
    const { width, height } = await viewBox(page);
    const diagonal = await page.evaluate(() => globalThis.pith.model.diagonal());
    await use(page, { tool: 'cut', keep: 'both' });
    for (const [i, tilt] of [-30, 0, 30, 60].entries()) {
      await drag(page, [[width / 2 - tilt, height * 0.14], [width / 2 + tilt, height * 0.97]]);
      await until(page, (s) => s.document.cuts && s.document.cuts.length === i + 1);
      await settled(page);
    }
    const { cuts } = (await state(page)).document;
    for (const { gap } of cuts) assert.ok(gap > 0.1 * diagonal && gap < 0.14 * diagonal, `a gap of ${gap} in a model of ${diagonal}`);
    await apply(page, 'Cut', [{ op: 'cut.plane', plane: { point: [100, 0, 0], normal: [1, 0, 0] }, keep: 'positive' }]);
    const card = page.locator('.stage-card');
    await card.getByText('The cuts leave nothing of the model.').waitFor();
    await card.getByText('Undo', { exact: true }).click();
    await card.waitFor({ state: 'detached' });
    assert.equal(await count(page, 'cuts'), 4);
  });

  test('a page whose server was killed says that it is not running', async () => {
    const page = await open('kiwi.pith');
    await desk.server.stop('SIGKILL');
    await page.locator('.banner.of-connection', { hasText: 'is not running' }).waitFor();
    desk.opened.problems.length = 0;          // the browser reports that nobody answers
  });

  test('two pages of one document do not harm it', async () => {
    const page = await open('kiwi.pith');
    const second = await openPage(desk.server);
    const answers = await Promise.all([0, 1, 2, 3, 4, 5].map((i) => apply(i % 2 ? second.page : page, `Title ${i}`, [{ op: 'set', path: 'title', value: `T${i}` }])));
    assert.ok(answers.some((done) => done));
    await until(page, (s) => s.connection === "open");
    const [a, b] = await Promise.all([state(page), state(second.page)]);
    assert.equal(a.revision, b.revision);
    assert.deepEqual(a.document, b.document);
    assert.equal(a.undo.length, answers.filter((done) => done).length);
    execFileSync(program, ['validate', desk.server.document]);
    await second.close();
  });
});
