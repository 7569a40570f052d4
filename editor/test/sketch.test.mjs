// The sketch as a hand uses it: the real program, a real browser. What was drawn is read from the document that the server
// holds; what curves become is compared with what the library makes of them.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { after, before, describe, test } from 'node:test';
import { Desk, join, pixels, program, readDocument, readFileSync, rmSync, settled, state, workFolder, writeFileSync } from './harness.mjs';
import { load } from './modules.mjs';

let desk;

/** Opens a document of examples/ with the sketch open; `built`: it is built after every change. */
async function open(name = 'sketch.pith', { change, built = false, ...options } = {}) {
  const page = await desk.openExample(name, change, { built: false, width: 1440, height: 900, ...options });
  if (!built) await page.evaluate(() => globalThis.pith.actions.automatic(false));
  await page.keyboard.press('k');
  await page.locator('[data-pane=horizontal] canvas').waitFor();
  await page.waitForTimeout(150);
  return page;
}

const documentOf = (page) => page.evaluate(() => globalThis.pith.store.state.document);
const surface = async (page, name) => (await documentOf(page)).surfaces.find((each) => each.name === name);

/** Waits until a condition holds for the page's document. */
async function until(page, what, holds, timeout = 30000) {
  for (const end = Date.now() + timeout; !holds(await documentOf(page));) {
    if (Date.now() > end) throw new Error(`it did not come to pass that ${what}: ${JSON.stringify((await documentOf(page)).surfaces)} ${await messages(page)}`);
    await new Promise((resolve) => setTimeout(resolve, 40));
  }
}

const messages = (page) => page.locator('.message').allTextContents();

/* Points of a pane, model units, as places of the window. */
const places = (page, pane, points) => page.evaluate(([pane, points]) => {
  const own = globalThis.pith.sketch.panes[pane], box = own.canvas.getBoundingClientRect();
  return points.map(([x, y]) => { const [u, v] = own.toScreen(x, y); return [box.x + u, box.y + v]; });
}, [pane, points]);
const pixelOf = (page, pane) => page.evaluate((pane) => globalThis.pith.sketch.panes[pane].pixel, pane);

async function stroke(page, pane, points, { keys = [] } = {}) {
  const at = await places(page, pane, points);
  for (const key of keys) await page.keyboard.down(key);
  await page.mouse.move(...at[0]);
  await page.mouse.down();
  for (const point of at.slice(1)) await page.mouse.move(...point);
  await page.mouse.up();
  for (const key of keys) await page.keyboard.up(key);
}
async function click(page, pane, point, options) { await page.mouse.click(...(await places(page, pane, [point]))[0], options); }
const tool = (page, label) => page.getByRole('radiogroup', { name: 'Sketching tools' }).getByRole('radio', { name: label, exact: true }).click();
const choose = (page, name) => page.evaluate((name) => globalThis.pith.store.set({ selectedSurface: name }), name);

const loop = (cx, cy, rx, ry, wave = () => 1) => Array.from({ length: 61 }, (_, i) => {
  const turn = (2 * Math.PI * i) / 60;
  return [cx + rx * wave(turn) * Math.cos(turn), cy + ry * wave(turn) * Math.sin(turn)];
});
const away = (line, [x, y]) => Math.min(...line.slice(1).map(([bx, by], i) => {
  const [ax, ay] = line[i], dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
  const t = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}));
const near = (a, b, most, what) => assert.ok(Math.abs(a - b) <= most, `${what}: ${a}, expected ${b}, off by ${Math.abs(a - b)}`);

/* ---- curves without a browser --------------------------------------------------------------------------------------------- */

describe('curves of the sketch', () => {
  let curve, fit, bending, folder;
  before(async () => {
    [curve, fit, bending] = [await load('sketch/curve'), await load('sketch/fit'), await load('sketch/bend')];
    folder = workFolder();
  });
  after(() => rmSync(folder, { recursive: true, force: true }));

  /* What the program makes of the sketch's skin, or of a curve in its place. */
  function applied(points, operation, closed = false) {
    const path = join(folder, 'examples', 'applied.pith'), text = readDocument(join(folder, 'examples', 'sketch.pith'));
    if (closed) text.surfaces[0].horizontal = points;
    else text.surfaces[0].vertical = points;
    writeFileSync(path, JSON.stringify(text));
    execFileSync(program, ['apply', path, '--op', JSON.stringify({ surface: 'skin', pane: closed ? 'horizontal' : 'vertical', ...operation })]);
    return readDocument(path).surfaces[0][closed ? 'horizontal' : 'vertical'];
  }
  const profile = [[0, 1], [0.4, 0.95], [0.8, 0.7], [1, 0.3], [1.05, 0], [1, -0.3], [0.8, -0.7], [0.4, -0.95], [0, -1]];
  const ring = Array.from({ length: 14 }, (_, i) => { const a = (2 * Math.PI * i) / 14; return [(1 + 0.1 * Math.cos(3 * a)) * Math.cos(a), (1 + 0.1 * Math.cos(3 * a)) * Math.sin(a)]; });

  test('a spline runs through its knots, is straight between corners, and goes round a circle', () => {
    const { Spline, knotsOf } = curve;
    const knots = knotsOf(ring, true), spline = new Spline(knots, true);
    for (const { x, y } of knots) assert.ok(spline.nearest(x, y).distance < 1e-12);
    const square = new Spline(knotsOf([[0, 0], [0, 0], [1, 0], [1, 0], [1, 1], [1, 1], [0, 1], [0, 1]], true), true);
    near(square.length, 4, 1e-9, 'round a square');
    const circle = new Spline(knotsOf(loop(0, 0, 1, 1).slice(0, 60), true), true);
    near(circle.length, 2 * Math.PI, 1e-3, 'round a circle');
    near(curve.area2(circle.line) / 2, Math.PI, 1e-3, 'the area of a circle');
    // An end on the axis meets it at a right angle, so that the surface has no tip there.
    const half = new Spline(knotsOf(profile, false), false, true), [[, y0], [x1, y1]] = half.line;
    assert.ok(Math.abs(y1 - y0) < 0.1 * x1, `it leaves the axis by ${y1 - y0} over ${x1}`);
  });

  test('a curve is drawn as the library sweeps it', () => {
    const { Spline, knotsOf } = curve, path = join(folder, 'examples', 'swept.pith'), out = join(folder, 'swept.ply');
    const text = readDocument(join(folder, 'examples', 'sketch.pith'));
    for (const vertical of [text.surfaces[0].vertical, profile, [[0, 1], [0, 1], [0.9, 0.4], [0.9, 0.4], [0.2, -0.3], [0.7, -1]]]) {
      text.surfaces[0] = { name: 'skin', kind: 'around', vertical, along: 200 };
      delete text.shape;
      writeFileSync(path, JSON.stringify({ ...text, shape: { fruit: {} } }));
      execFileSync(program, ['surfaces', path, '-o', out]);
      const bytes = readFileSync(out), head = bytes.subarray(0, bytes.indexOf('end_header\n') + 11), words = head.toString().split('\n');
      const count = Number(words.find((line) => line.startsWith('element vertex')).split(' ')[2]);
      const sizes = { float: 4, double: 8, uchar: 1 }, wide = words.slice(words.findIndex((line) => line.startsWith('element vertex')) + 1)
        .slice(0, words.slice(words.findIndex((line) => line.startsWith('element vertex')) + 1).findIndex((line) => line.startsWith('element')))
        .filter((line) => line.startsWith('property')).reduce((sum, line) => sum + sizes[line.split(' ')[1]], 0);
      const double = words.some((line) => line === 'property double x'), spline = new Spline(knotsOf(vertical, false), false, true);
      let worst = 0, far = 0;
      for (let i = 0; i < count; ++i) {
        const [x, y, z] = [0, 1, 2].map((k) => (double ? bytes.readDoubleLE(head.length + wide * i + 8 * k) : bytes.readFloatLE(head.length + wide * i + 4 * k)));
        worst = Math.max(worst, spline.nearest(Math.hypot(x, y), z).distance);
        far = Math.max(far, Math.hypot(x, y));
      }
      assert.ok(worst < 2e-3, `a vertex is ${worst} from the curve`);
      near(far, Math.max(...spline.line.map(([r]) => r)), 2e-3, 'how far out it goes');
    }
  });

  test('points become corners when they are given twice, and are written so again', () => {
    const points = [[0, 1], [1, 1], [1, 1], [1, -1], [0, -1]];
    assert.deepEqual(curve.pointsOf(curve.knotsOf(points, false)), points);
    assert.deepEqual(curve.knotsOf([[0, 0], [1, 0], [1, 1], [0, 0]], true).map(({ corner }) => corner), [true, false, false]);
  });

  test('a trembling hand’s circle becomes a few knots within two pixels of it', () => {
    const pixel = 0.01, hand = loop(0, 0, 1, 1).flatMap(([x, y], i, all) => {
      const [u, v] = all[(i + 1) % all.length];
      return [[x, y], [(x + u) / 2, (y + v) / 2]];
    }).map(([x, y], i) => [x + 0.006 * Math.sin(7 * i), y + 0.006 * Math.cos(11 * i)]);
    assert.equal(fit.isLoop(hand, 14 * pixel), true);
    const knots = fit.fitStroke(hand, true, { pixel, half: false });
    assert.ok(knots.length >= 4 && knots.length <= 16, `${knots.length} knots`);
    const { line } = new curve.Spline(knots, true);
    const worst = Math.max(...line.map(([x, y]) => Math.abs(Math.hypot(x, y) - 1)));
    assert.ok(worst <= 2 * pixel, `off by ${worst / pixel} pixels`);
    assert.ok(knots.every(({ corner }) => !corner));
  });

  test('a sharp bend of a stroke is a corner, where it is', () => {
    const side = (n, f) => Array.from({ length: n }, (_, i) => f(i / n));
    const hook = [...side(40, (t) => [t, 0]), ...side(41, (t) => [1, -t])];
    const knots = fit.fitStroke(hook, false, { pixel: 0.01, half: false }), corners = knots.filter(({ corner }) => corner);
    assert.equal(corners.length, 1);
    assert.ok(Math.hypot(corners[0].x - 1, corners[0].y) < 0.03, `at ${corners[0].x}, ${corners[0].y}`);
    assert.ok(knots.length <= 4, `${knots.length} knots`);
  });

  test('vertical strokes are brought right of the axis, from above to below', () => {
    const knots = [[-0.02, -1], [-0.01, -0.9], [0.9, 0], [0.03, 0.9], [0.05, 1]].map(([x, y]) => ({ x, y, corner: false }));
    const made = fit.toHalfPlane(knots, false, 0.06, 0.01);
    assert.deepEqual(made.map(({ x, y }) => [x, y]), [[0, 1], [0.03, 0.9], [0.9, 0], [0, -0.9]]);
  });

  test('bending shows what the library does', () => {
    for (const [points, closed, grabbed, to, reach] of [[profile, false, 3, [1.3, 0.45], 0.9], [profile, false, 4, [0.7, 0.1], 1.2], [ring, true, 0, [1.4, 0.2], 1.2],
                                                        [[[0, 1], [1, 1], [1, 1], [1, -1], [0, -1]], false, 1, [1.2, 1.1], 5]]) {
      const knots = curve.knotsOf(points, closed), shown = curve.pointsOf(bending.bend(knots, closed, grabbed, ...to, reach));
      const made = applied(points, { op: 'surface.deform', drag: [[knots[grabbed].x, knots[grabbed].y], to], reach }, closed);
      const off = Math.max(...shown.flat().map((x, i) => Math.abs(x - made.flat()[i])));
      assert.equal(shown.length, made.length);
      assert.ok(off < 1e-6, `off by ${off}`);
      assert.ok(Math.max(...made.flat().map((x, i) => Math.abs(x - points.flat()[i]))) > 0.1, 'something moved');
    }
  });

  test('brushing everything shows what smoothing does', () => {
    for (const [points, closed] of [[profile, false], [ring, true]]) {
      const shown = curve.pointsOf(bending.smoothed(curve.knotsOf(points, closed), closed, 0.3, () => 1));
      const made = applied(points, { op: 'surface.smooth', amount: 0.3 }, closed);
      const off = Math.max(...shown.flat().map((x, i) => Math.abs(x - made.flat()[i])));
      assert.ok(off < 1e-6, `off by ${off}`);
    }
  });

  test('sides of a stroke: right of it as it runs, straight on beyond its ends, outside of a loop', () => {
    const { isPositive } = curve, down = [[0, 1], [0, 0], [1, -1]];
    assert.equal(isPositive(down, false, -0.5, 0.5), true);
    assert.equal(isPositive(down, false, 0.5, 0.5), false);
    assert.equal(isPositive(down, false, -0.1, 9), true);
    assert.equal(isPositive(down, false, 9, -8), false);
    assert.equal(isPositive(down, false, 8, -9), true);
    assert.equal(isPositive(down, false, -0.5, -0.1), true, 'beside the bend');
    assert.equal(isPositive(loop(0, 0, 1, 1), true, 0.5, 0), false);
    assert.equal(isPositive(loop(0, 0, 1, 1), true, 2, 0), true);
  });
});

/* ---- the page --------------------------------------------------------------------------------------------------------------- */

describe('the sketch', { timeout: 900000 }, () => {
  desk = new Desk();

  test('a tomato from nothing: skin, chambers in five folds, colours, a cut, and its section', async () => {
    const page = await open('kiwi.pith', { built: true, change: (text) => { delete text.cuts; } });
    await page.locator('.sketch-start').getByText('Sketch from nothing').click();
    await until(page, 'there is a skin', (text) => text.surfaces?.length === 1 && text.shape.surfaces[0] === 'skin' && !text.depth);
    const folds = page.locator('[data-key="sketch folds"]');
    await folds.fill('5');
    await folds.press('Enter');
    await until(page, 'there are five folds', (text) => text.sketch?.folds === 5);

    // The skin anew: from a dent on the axis to the axis below.
    await page.getByRole('radio', { name: 'Redraw skin' }).click();
    const half = Array.from({ length: 50 }, (_, i) => (Math.PI * (24.5 - i)) / 49)
      .map((a) => [Math.max(0.02, Math.cos(a)), 0.8 * Math.sin(a) - 0.12 * Math.exp(-12 * (a - Math.PI / 2) ** 2)]);
    await stroke(page, 'vertical', half);
    await until(page, 'the skin is drawn', (text) => text.surfaces[0].vertical.length !== 6);
    await stroke(page, 'horizontal', loop(0, 0, 1, 1, (a) => 1 + 0.04 * Math.cos(5 * a)));
    await until(page, 'the skin runs across', (text) => text.surfaces[0].horizontal);
    const skin = await surface(page, 'skin');
    assert.equal(skin.vertical[0][0], 0, 'it begins on the axis');
    assert.equal(skin.vertical.at(-1)[0], 0, 'it ends on the axis');
    assert.ok(skin.vertical[0][1] > skin.vertical.at(-1)[1], 'from above to below');
    const { Spline, knotsOf } = await load('sketch/curve');
    const drawn = new Spline(knotsOf(skin.vertical, false), false, true), pixel = await pixelOf(page, 'vertical');
    const off = Math.max(...half.slice(2, -2).map(([x, y]) => drawn.nearest(x, y).distance));
    assert.ok(off < 4 * pixel, `the curve is ${off / pixel} pixels from the stroke`);

    // Two chambers' loops: one stands for all folds, another gives every fold its own.
    await page.getByRole('radio', { name: 'New surface' }).click();
    await stroke(page, 'vertical', loop(0.5, 0, 0.26, 0.42));
    const name = page.locator('dialog').getByLabel('Name');
    assert.equal(await name.inputValue(), 'chambers');
    await name.fill('seed chambers');
    await name.press('Enter');
    await until(page, 'there are chambers', (text) => text.surfaces[1]?.kind === 'chambers' && text.surfaces[1].name === 'seed chambers');
    const middle = (fold) => [0.5 * Math.cos((2 * Math.PI * (fold + 0.5)) / 5), 0.5 * Math.sin((2 * Math.PI * (fold + 0.5)) / 5)];
    await stroke(page, 'horizontal', loop(...middle(1), 0.2, 0.2));
    await until(page, 'one loop stands for all', (text) => text.surfaces[1].horizontals?.length === 1);
    await stroke(page, 'horizontal', loop(...middle(3), 0.24, 0.17));
    await until(page, 'each fold has a loop', (text) => text.surfaces[1].horizontals?.length === 5);
    const chambers = await surface(page, 'seed chambers'), at = (points) => points.reduce(([x, y], [u, v]) => [x + u / points.length, y + v / points.length], [0, 0]);
    chambers.horizontals.forEach((points, fold) => {
      const [x, y] = at(points), [u, v] = middle(fold);
      assert.ok(Math.hypot(x - u, y - v) < 0.05, `the loop of fold ${fold} is at ${x}, ${y}`);
    });

    // Colours, then a cut across: green chambers in red flesh, as the program says too.
    for (const [name, key, colour] of [['skin', 'back', '#e0402a'], ['skin', 'front', '#c02010'], ['seed chambers', 'front', '#d8603a']]) {
      const index = name === 'skin' ? 0 : 1;
      await choose(page, name);
      const digits = page.locator(`[data-key="surfaces[${index}].colours.${key}#"]`);
      await digits.fill(colour);
      await digits.press('Enter');
      await until(page, `${name} is coloured`, (text) => text.surfaces[index].colours[key] === colour);
    }
    await page.getByRole('button', { name: 'Another colour inside' }).click();
    const inside = page.locator('[data-key="surfaces[1].colours.back#"]');
    await inside.fill('#40a030');
    await inside.press('Enter');
    await until(page, 'the chambers are green inside', (text) => text.surfaces[1].colours.back === '#40a030');
    await page.evaluate(() => globalThis.pith.actions.apply('Cut', [{ op: 'cut.plane', plane: { point: [0, 0, 0.001], normal: [0, 0, 1] }, keep: 'negative' }]));
    await page.evaluate(() => { globalThis.pith.viewport.touched = true; globalThis.pith.commands.run('from-top'); });
    await settled(page, 300000);
    await page.waitForFunction(() => globalThis.pith.viewport.fine, undefined, { timeout: 120000, polling: 100 });
    const spots = [middle(1), middle(3), [0, 0]].map(([x, y]) => [x, y, 0.0005]);
    const seen = await page.evaluate((spots) => spots.map((spot) => {
      const { overlay, table } = globalThis.pith.viewport, at = overlay.project(table.target.clone().set(...spot));
      return [Math.round(at.x), Math.round(at.y)];
    }), spots);
    const colours = await pixels(page, seen), words = ['in fold 1', 'in fold 3', 'on the axis'];
    const [one, three, core] = colours;
    for (const [i, green] of [one, three].entries()) assert.ok(green[1] > green[0] + 15, `${words[i]} it is ${green}, expected green`);
    assert.ok(core[0] > core[1] + 30, `on the axis it is ${core}, expected red`);
    await page.keyboard.press('Control+s');
    await page.getByText('Saved kiwi.pith.').waitFor();
    const asked = execFileSync(program, ['sample', desk.server.document], { input: spots.map((spot) => spot.slice(0, 2).concat(-0.001).join(' ')).join('\n') + '\n', encoding: 'utf8' })
      .trim().split('\n').map((line) => line.split(/\s+/).map(Number));
    assert.ok(asked[0][1] > asked[0][0] && asked[2][0] > asked[2][1], `the program samples ${asked}`);
  });

  test('points are dragged, added, made corners and taken away; each is one step that undo takes back', async () => {
    const page = await open();
    await choose(page, 'skin');
    await tool(page, 'Points');
    const before = (await surface(page, 'skin')).vertical, pixel = await pixelOf(page, 'vertical');
    await stroke(page, 'vertical', [before[3], [1.1, 0], [1.2, 0.05]]);
    await until(page, 'the point moved', (text) => text.surfaces[0].vertical[3][0] !== before[3][0]);
    let now = (await surface(page, 'skin')).vertical;
    assert.ok(Math.hypot(now[3][0] - 1.2, now[3][1] - 0.05) < pixel, `it is at ${now[3]}`);
    assert.deepEqual(now.filter((_, i) => i !== 3), before.filter((_, i) => i !== 3), 'no other moved');
    // An end pulled a little off the axis stays on it, and goes up.
    await stroke(page, 'vertical', [now[0], [0.01, 0.95], [0.6 * 8 * pixel, 1]]);
    await until(page, 'the end moved', (text) => text.surfaces[0].vertical[0][1] > 0.95);
    assert.equal((await surface(page, 'skin')).vertical[0][0], 0);
    // Double click on the curve: one more; on a point: a corner.
    const { Spline, knotsOf } = await load('sketch/curve');
    now = (await surface(page, 'skin')).vertical;
    const between = new Spline(knotsOf(now, false), false, true).at(2, 0.5);
    const [[u, v]] = await places(page, 'vertical', [between]);
    await page.mouse.dblclick(u, v);
    await until(page, 'there is a point more', (text) => text.surfaces[0].vertical.length === now.length + 1);
    assert.ok(away((await surface(page, 'skin')).vertical, between) < pixel);
    await page.keyboard.press('c');
    await until(page, 'it is a corner', (text) => text.surfaces[0].vertical.length === now.length + 2);
    await page.keyboard.press('Delete');
    await until(page, 'it is gone', (text) => text.surfaces[0].vertical.length === now.length);
    for (let i = 0; i < 5; ++i) await page.keyboard.press('Control+z');
    await until(page, 'all is as it was', (text) => JSON.stringify(text.surfaces[0].vertical) === JSON.stringify(before));
  });

  test('a curve is bent where it is grabbed, as far as the wheel says; smoothing and redrawing change it too', async () => {
    const page = await open('sketch.pith', { change: (text) => {
      text.surfaces[0].vertical = Array.from({ length: 19 }, (_, i) => { const a = (Math.PI * (9 - i)) / 18; return [i % 18 === 0 ? 0 : Number(Math.cos(a).toFixed(4)), Number(Math.sin(a).toFixed(4))]; });
    } });
    await choose(page, 'skin');
    await tool(page, 'Bend');
    const before = (await surface(page, 'skin')).vertical, [[x, y], [u, v]] = await places(page, 'vertical', [[1, 0], [1.3, 0]]);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move((x + u) / 2, v);
    const wide = await page.evaluate(() => globalThis.pith.sketch.session.values.reach);
    for (let i = 0; i < 4; ++i) await page.mouse.wheel(0, 100);
    await page.waitForFunction((wide) => globalThis.pith.sketch.session.values.reach < 0.7 * wide, wide);
    await page.mouse.move(u, v);
    const reach = await page.evaluate(() => globalThis.pith.sketch.session.values.reach);
    const held = await page.evaluate(() => globalThis.pith.sketch.session.curves.find((each) => each.pane === 'vertical').knots.map(({ x, y }) => [x, y]));
    await page.mouse.up();
    await until(page, 'it is bent', (text) => Math.max(...text.surfaces[0].vertical.map(([r]) => r)) > 1.25);
    const now = (await surface(page, 'skin')).vertical;
    assert.equal(now.length, before.length);
    const off = Math.max(...now.flat().map((each, i) => Math.abs(each - held.flat()[i])));
    assert.ok(off < 0.01, `what the hand saw was off by ${off}`);
    now.forEach((point, i) => {
      const along = (Math.abs(i - 9) * Math.PI) / 18;
      if (along > reach + 0.02) assert.deepEqual(point, before[i], `point ${i} is beyond the reach ${reach}`);
    });
    // A smoothing brush over the bump, then the button.
    await tool(page, 'Smooth');
    const bumps = (points) => points.slice(1, -1).reduce((sum, [r, z], i) => sum + Math.hypot(points[i][0] - 2 * r + points[i + 2][0], points[i][1] - 2 * z + points[i + 2][1]), 0);
    await stroke(page, 'vertical', Array.from({ length: 12 }, (_, i) => [1.25, i % 2 ? 0.08 : -0.08]));
    await until(page, 'the brush smoothed it', (text) => Math.max(...text.surfaces[0].vertical.map(([r]) => r)) < 1.27);
    const brushed = (await surface(page, 'skin')).vertical;
    assert.deepEqual([brushed[0], brushed[18]], [before[0], before[18]], 'ends stay');
    await page.getByRole('button', { name: 'Smooth all' }).click();
    await until(page, 'the button smoothed it', (text) => bumps(text.surfaces[0].vertical) < 0.999 * bumps(brushed));
  });

  test('a cutting stroke erases the side that is clicked', async () => {
    const page = await open();
    await choose(page, 'skin');
    await tool(page, 'Erase');
    await stroke(page, 'vertical', [[0.2, 0.4], [0.7, 0.42], [1.3, 0.4]]);
    await page.getByText('From skin erase').waitFor();
    await page.keyboard.press('Escape');
    assert.equal(await page.getByText('From skin erase').count(), 0);
    // It bounds the body, and with a hole in it it would not: the server says so, and nothing has happened.
    await page.evaluate(() => globalThis.pith.actions.apply('Another', [
      { op: 'set', path: 'surfaces[1]', value: { name: 'core', kind: 'around', vertical: [[0, 0.5], [0.5, 0.4], [0.5, -0.4], [0, -0.5]] } }]));
    await choose(page, 'core');
    await stroke(page, 'vertical', [[-0.2, 0.1], [0.4, 0.11], [1, 0.1]]);
    await page.getByText('From core erase').waitFor();
    await click(page, 'vertical', [0.2, 0.3]);
    await until(page, 'it is erased', (text) => text.surfaces[1].erase?.length === 1);
    const [{ vertical, side = 'positive' }] = (await surface(page, 'core')).erase;
    assert.equal(side, 'negative', 'left of a stroke from left to right is above it');
    assert.ok(vertical.every(([, z]) => Math.abs(z - 0.1) < 0.03), JSON.stringify(vertical));
    await page.locator('[data-section="surface.erase"] .section-head').click();
    await page.getByRole('button', { name: 'Bring this back' }).click();
    await until(page, 'it is back', (text) => !text.surfaces[1].erase);
  });

  test('a picture is loaded, laid with its handles, and gives colours; folds are turned', async () => {
    const page = await open('sketch.pith', { change: (text) => { text.sketch.folds = 3; } });
    const picture = await page.evaluate(async () => {
      const canvas = new OffscreenCanvas(60, 40), brush = canvas.getContext('2d');
      brush.fillStyle = '#204080';
      brush.fillRect(0, 0, 30, 40);
      brush.fillStyle = '#e0a010';
      brush.fillRect(30, 0, 30, 40);
      return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
    });
    await page.locator('[data-key="pane picture horizontal"]').click();
    await page.locator('dialog input[type=file]').setInputFiles({ name: 'across.png', mimeType: 'image/png', buffer: Buffer.from(picture) });
    await until(page, 'the document names it', (text) => text.sketch.horizontal?.image === 'across.png');
    await page.waitForFunction(() => globalThis.pith.sketch.session.pictures.horizontal.image);
    const laid = (await documentOf(page)).sketch.horizontal;
    near(laid.x, 0, 1e-9, 'its middle');
    await stroke(page, 'horizontal', [[0.1, 0.1], [0.2, 0.15], [0.3, 0.1]]);
    await until(page, 'it moved', (text) => Math.abs(text.sketch.horizontal.x - 0.2) < 0.02 && Math.abs(text.sketch.horizontal.y) < 0.02);
    const { x, y, width } = (await documentOf(page)).sketch.horizontal, tall = (width * 40) / 60, pixel = await pixelOf(page, 'horizontal');
    await stroke(page, 'horizontal', [[x + width / 2, y + tall / 2], [x + 0.75 * width, y + 0.75 * tall]]);
    await until(page, 'it grew', (text) => Math.abs(text.sketch.horizontal.width - 1.5 * width) < 0.02 * width);
    await stroke(page, 'horizontal', [[x, y + 0.75 * tall + 26 * pixel], [x - 0.75 * tall - 26 * pixel, y]]);
    await until(page, 'it turned', (text) => Math.abs(text.sketch.horizontal.turn - 90) < 1.5);
    // Turned to the left: what was left is below now, and what was right above.
    await page.keyboard.down('Alt');
    await click(page, 'horizontal', [x, y - 0.3]);
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.paintColour), '#204080');
    await tool(page, 'Pick a colour');
    await click(page, 'horizontal', [x, y + 0.3]);
    await page.keyboard.up('Alt');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.paintColour), '#e0a010');
    await choose(page, 'skin');
    await page.getByRole('button', { name: 'Colour skin' }).click();
    await until(page, 'the skin has it', (text) => text.surfaces[0].colours.front === '#e0a010');
    // The knob of the first fold.
    await tool(page, 'Points');
    const handle = await page.evaluate(() => { const pane = globalThis.pith.sketch.panes.horizontal; return Math.max(70, 0.42 * Math.min(pane.width, pane.height)) * pane.pixel; });
    await stroke(page, 'horizontal', [[handle, 0], [0.8 * handle, 0.6 * handle], [0.6 * handle, 0.8 * handle]]);
    await until(page, 'the folds turned', (text) => Math.abs(text.sketch.fold_angle - 53.13) < 1);
  });

  test('the panel names, shows, copies, orders and removes surfaces, and says which bounds the body', async () => {
    const page = await open();
    await choose(page, 'skin');
    const name = page.locator('[data-key="surfaces[0].name"]');
    await name.fill('peel');
    await name.press('Enter');
    await until(page, 'it is called peel', (text) => text.surfaces[0].name === 'peel' && text.shape.surfaces[0] === 'peel');
    const menu = async (of, item) => { await page.locator(`[data-key="surface menu ${of}"]`).click(); await page.getByRole('menuitem', { name: item }).click(); };
    await menu('peel', 'Duplicate');
    await until(page, 'there are two', (text) => text.surfaces.length === 2 && text.surfaces[1].name === 'peel 2');
    await page.locator('[data-section="sketch.surfaces"] [data-key="eye peel"]').click();
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.shownSurfaces.peel), false);
    await menu('peel 2', 'Move up');
    await until(page, 'it is first', (text) => text.surfaces[0].name === 'peel 2');
    await menu('peel 2', 'Let it bound the body');
    await until(page, 'both bound', (text) => text.shape.surfaces.length === 2);
    await menu('peel', 'Remove');
    await until(page, 'one is left', (text) => text.surfaces.length === 1 && JSON.stringify(text.shape.surfaces) === '["peel 2"]');
    await menu('peel 2', 'Remove');
    await page.getByText('peel 2 bounds the body; let another closed surface bound it first.').waitFor();
    // Grains lie on a surface, and have a form of their own.
    await page.locator('[data-key="add surface"]').click();
    await page.getByRole('menuitem', { name: 'Grains on a surface' }).click();
    await until(page, 'there are grains', (text) => text.surfaces[1]?.kind === 'grains' && text.surfaces[1].on === 'peel 2');
    const form = page.locator('.grain-pane'), before = (await surface(page, 'seeds')).grain.profile;
    await form.scrollIntoViewIfNeeded();
    const box = await form.boundingBox(), turn = (i) => (2 * Math.PI * i) / 40;
    await page.mouse.move(box.x + 95 + 60, box.y + 60);
    await page.mouse.down();
    for (let i = 1; i <= 40; ++i) await page.mouse.move(box.x + 95 + 60 * Math.cos(turn(i)), box.y + 60 + 30 * Math.sin(turn(i)));
    await page.mouse.up();
    await until(page, 'their profile is drawn', (text) => JSON.stringify(text.surfaces[1].grain.profile) !== JSON.stringify(before));
    // A stroke along the axis says where they are.
    await tool(page, 'Draw');
    await page.getByRole('radio', { name: 'Strew seeds' }).click();
    await stroke(page, 'vertical', [[0.95, 0.3], [1, 0.1], [0.98, -0.2], [0.9, -0.4]]);
    await until(page, 'they have a place', (text) => text.surfaces[1].region?.length === 1);
    const [brush] = (await surface(page, 'seeds')).region;
    assert.equal(brush.repeat, 'around');
    assert.ok(brush.radius > 0 && brush.points.every(([x, y]) => x > 0.85 && y === 0), JSON.stringify(brush));
  });

  test('another individual of its kind, and the drawing again', async () => {
    const page = await open('sketch.pith', { change: (text) => {
      text.surfaces[0].horizontal = Array.from({ length: 30 }, (_, i) => { const a = (2 * Math.PI * i) / 30, r = 1 + 0.06 * Math.sin(3 * a) + 0.04 * Math.cos(7 * a); return [r * Math.cos(a), r * Math.sin(a)]; });
    } });
    await page.getByRole('button', { name: 'Another one' }).click();
    await until(page, 'it is varied', (text) => text.sketch.variation?.seed > 0);
    const { seed } = (await documentOf(page)).sketch.variation;
    const strength = page.locator('[data-key="sketch.variation.strength"]');
    await strength.fill('2');
    await strength.press('Enter');
    await until(page, 'it is varied more', (text) => text.sketch.variation.strength === 2 && text.sketch.variation.seed === seed);
    await page.getByRole('button', { name: 'As it was drawn' }).click();
    await until(page, 'it is as drawn', (text) => !text.sketch.variation);
  });

  test('keys take up tools and give up what is under way; clicks draw point by point; the panes close', async () => {
    const page = await open();
    await page.locator('[data-pane=vertical] canvas').focus();
    for (const [key, name] of [['e', 'edit'], ['b', 'bend'], ['s', 'smooth'], ['x', 'erase'], ['i', 'pick'], ['r', 'picture'], ['d', 'draw']]) {
      await page.keyboard.press(key);
      assert.equal(await page.evaluate(() => globalThis.pith.sketch.session.values.tool), name, `${key} takes ${name}`);
      assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'select', 'the tool of the view is another thing');
    }
    await click(page, 'vertical', [0.2, 0.5]);
    await click(page, 'vertical', [0.5, 0.2]);
    await page.keyboard.press('Escape');
    for (const point of [[0.01, 0.5], [0.5, 0.3], [0.5, -0.3], [0.01, -0.5]]) await click(page, 'vertical', point);
    await page.keyboard.press('Enter');
    await page.locator('dialog').getByLabel('Name').press('Enter');
    await until(page, 'there is another surface', (text) => text.surfaces[1]?.name === 'flesh');
    const { vertical, kind } = await surface(page, 'flesh'), pixel = await pixelOf(page, 'vertical');
    assert.equal(kind, 'around');
    assert.equal(vertical.length, 4);
    assert.deepEqual([vertical[0][0], vertical[3][0]], [0, 0], 'its ends snapped to the axis');
    assert.ok(Math.hypot(vertical[1][0] - 0.5, vertical[1][1] - 0.3) < 2 * pixel, `it runs through ${vertical[1]}`);
    // What the server refuses leaves everything as it is, and says why.
    await page.keyboard.press('d');
    await stroke(page, 'vertical', [[0.2, 0.6], [0.8, -0.2], [0.8, 0.2], [0.2, -0.6]].flatMap(([x, y], i, all) => {
      const [u, v] = all[Math.min(i + 1, 3)];
      return Array.from({ length: 8 }, (_, k) => [x + ((u - x) * k) / 8, y + ((v - y) * k) / 8]);
    }));
    await page.locator('dialog').getByLabel('Name').press('Enter');
    await page.locator('.message', { hasText: /cross/ }).waitFor();
    assert.equal((await documentOf(page)).surfaces.length, 2);
    await page.keyboard.press('k');
    await page.locator('.sketch').waitFor({ state: 'hidden' });
  });
});
