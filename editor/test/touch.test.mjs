// Fingers and pens: what they draw, and how two fingers move the view. The gestures go in where the browser takes those of
// a touch screen or a tablet.
import assert from 'node:assert/strict';
import { after, afterEach, describe, test } from 'node:test';
import { closeBrowser, viewBox } from './harness.mjs';
import { applied, choose, eventually, example, openFake, settle } from './page.mjs';

let opened;

/* fingers(paths): each path is a list of points of the view, [u, v] from its middle in parts of its width and height;
   all fingers go down together, move together and are lifted together. */
async function open(tool, values = {}) {
  opened = await openFake(example('kiwi', (document) => { document.cuts = []; document.camera = { direction: [0, -1, 0], up: [0, 0, 1], field_of_view: 24 }; }),
                          { width: 1024, height: 768, touch: true });
  const { page, fake } = opened;
  await choose(page, { tool, ...values });
  const device = await page.context().newCDPSession(page), box = await viewBox(page);
  const place = ([u, v]) => ({ x: box.x + box.width * (0.5 + u), y: box.y + box.height * (0.5 + v) });
  const touch = (type, points) => device.send('Input.dispatchTouchEvent', { type, touchPoints: points.map((point, id) => ({ ...place(point), id, radiusX: 8, radiusY: 8, force: 0.5 })) });
  const fingers = async (paths, steps = 8) => {
    const at = (t) => paths.map(([from, to]) => from.map((x, k) => x + (to[k] - x) * t));
    await touch('touchStart', at(0));
    for (let i = 1; i <= steps; ++i) await touch('touchMove', at(i / steps));
    await touch('touchEnd', []);
    await settle(page);
  };
  const pen = async (path, { button = 'left' } = {}) => {
    const send = (type, point, buttons) => device.send('Input.dispatchMouseEvent', { type, ...place(point), button, buttons, clickCount: 1, pointerType: 'pen', force: 0.6 });
    const held = button === 'left' ? 1 : 2;
    await send('mouseMoved', path[0], 0);
    await send('mousePressed', path[0], held);
    for (const point of path.slice(1)) await send('mouseMoved', point, held);
    await send('mouseReleased', path.at(-1), held);
    await settle(page);
  };
  const camera = () => page.evaluate(() => {
    const { camera, target } = globalThis.pith.viewport.table;
    return { eye: camera.position.toArray(), target: target.toArray(), distance: camera.position.distanceTo(target), fingers: globalThis.pith.viewport.hands.fingers };
  });
  return { page, fake, touch, fingers, pen, camera };
}

const far = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

describe('touch and pen', { timeout: 300000 }, () => {
  afterEach(async () => {
    const { problems = [] } = opened ?? {};
    await opened?.close();
    opened = undefined;
    assert.deepEqual(problems, [], 'the browser complained');
  });
  after(closeBrowser);

  test('one finger turns the model with the select tool', async () => {
    const { fingers, camera } = await open('select');
    const before = await camera();
    await fingers([[[-0.4, -0.3], [-0.2, -0.3]]]);
    const now = await camera();
    assert.ok(far(now.eye, before.eye) > 0.5 * before.distance, `the eye moved by ${far(now.eye, before.eye)}`);
    assert.ok(far(now.target, before.target) < 1e-9, 'about the same target');
    assert.ok(Math.abs(now.distance / before.distance - 1) < 1e-6, 'from the same distance');
  });

  test('two fingers apart come nearer by the same factor, in every tool, and draw nothing', async () => {
    for (const tool of ['select', 'depth', 'cut', 'fill', 'plane']) {
      const { page, fake, fingers, camera } = await open(tool);
      const painted = () => page.evaluate(() => [...globalThis.pith.viewport.meshes.get(0).painted]);
      const before = await camera(), paint = await painted();
      await fingers([[[-0.05, 0], [-0.1, 0]], [[0.05, 0], [0.1, 0]]]);
      const now = await camera();
      // Twice as far from one another on the glass: what is between them looks twice as large.
      assert.ok(Math.abs(before.distance / now.distance - 2) < 0.02, `${tool}: nearer by ${before.distance / now.distance}, expected 2`);
      assert.ok(far(now.target, before.target) < 0.02 * before.distance, `${tool}: the target moved by ${far(now.target, before.target)}`);
      assert.equal(now.fingers, 0, `${tool}: a finger is thought to be down still`);
      assert.equal(applied(fake).length, 0, `${tool} drew something`);
      assert.deepEqual(await painted(), paint, `${tool} left paint`);
      await opened.close();
      opened = { problems: opened.problems, close: async () => {} };
    }
  });

  test('two fingers side by side move the model with them', async () => {
    const { page, fingers, camera } = await open('depth');
    const on = () => page.evaluate(() => { const { table, canvas } = globalThis.pith.viewport; const p = table.box.getCenter(table.target.clone()).project(table.camera); return [p.x * canvas.clientWidth / 2, p.y * canvas.clientHeight / 2]; });
    const size = await viewBox(page), [x, y] = await on(), before = await camera();
    await fingers([[[-0.05, 0], [0.05, 0.1]], [[0.05, 0], [0.15, 0.1]]]);
    const [u, v] = await on(), now = await camera();
    assert.ok(Math.abs(u - x - 0.1 * size.width) < 4, `${u - x} pixels to the right, expected ${0.1 * size.width}`);
    assert.ok(Math.abs(y - v - 0.1 * size.height) < 4, `${y - v} pixels down, expected ${0.1 * size.height}`);
    assert.ok(Math.abs(now.distance / before.distance - 1) < 0.01, 'as near as before');
  });

  test('a second finger gives up the stroke of the first; lifting one goes on with the camera', async () => {
    const { fake, touch, camera, page } = await open('depth');
    await touch('touchStart', [[-0.1, 0]]);
    for (let i = 1; i <= 5; ++i) await touch('touchMove', [[-0.1 + 0.03 * i, 0]]);
    const before = await camera();
    await touch('touchStart', [[0.05, 0], [0.2, 0.2]]);
    for (let i = 1; i <= 5; ++i) await touch('touchMove', [[0.05, 0], [0.2 + 0.02 * i, 0.2]]);
    await touch('touchEnd', [[0.05, 0]]);
    for (let i = 1; i <= 5; ++i) await touch('touchMove', [[0.05 - 0.02 * i, 0]]);
    await touch('touchEnd', []);
    await settle(page);
    assert.equal(applied(fake).length, 0);
    assert.ok(far((await camera()).eye, before.eye) > 0, 'the camera moved');
    assert.equal((await camera()).fingers, 0);
  });

  test('a finger paints, cuts, and taps a fill', async () => {
    const { page, fake, fingers, touch } = await open('depth', { paint: 0.25 });
    await fingers([[[-0.1, 0], [0.1, 0.02]]], 12);
    await eventually('the stroke was asked for', () => applied(fake).length === 1);
    const [stroke] = applied(fake)[0].operations;
    assert.equal(stroke.op, 'depth.stroke');
    stroke.points.forEach((p) => assert.ok(Math.abs(Math.hypot(p[0], p[1], p[2] / 1.25) - 1) < 0.02, `${p} is not on the skin`));
    await choose(page, { tool: 'fill', paint: 0.75, crease: 25 });
    await touch('touchStart', [[0, 0]]);
    await touch('touchEnd', []);
    await eventually('the fill was asked for', () => applied(fake).length === 2);
    assert.equal(applied(fake)[1].operations[0].op, 'depth.fill');
    await choose(page, { tool: 'cut' });
    await fingers([[[0, -0.4], [0.02, 0.4]]], 12);
    await eventually('the cut was asked for', () => applied(fake).length === 3);
    assert.equal(applied(fake)[2].operations[0].op, 'cut.stroke');
  });

  test('a pen draws with its tip and turns the model with its button', async () => {
    const { fake, pen, camera } = await open('depth', { paint: 0.5 });
    const before = await camera();
    await pen(Array.from({ length: 12 }, (_, i) => [-0.1 + 0.02 * i, 0.01 * Math.sin(i)]));
    await eventually('the stroke was asked for', () => applied(fake).length === 1);
    assert.equal(applied(fake)[0].operations[0].op, 'depth.stroke');
    assert.ok(far((await camera()).eye, before.eye) < 1e-9, 'the camera stayed');
    await pen([[-0.1, 0], [-0.05, 0], [0, 0.02]], { button: 'right' });
    assert.ok(far((await camera()).eye, before.eye) > 0.1, 'the camera turned');
    assert.equal(applied(fake).length, 1);
  });
});
