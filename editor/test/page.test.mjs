// Everything around the view, as hands, keys and screen readers meet it. The server is one that builds nothing.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, describe, test } from 'node:test';
import { closeBrowser, root } from './harness.mjs';
import { applied, choose, eventually, example, openFake, settle } from './page.mjs';

const schema = JSON.parse(readFileSync(join(root, 'docs', 'pith.schema.json')));
let opened;

async function open(document = example('kiwi'), options = {}) {
  opened = await openFake(document, options);
  return opened;
}
const row = (page, label) => page.locator('.row', { has: page.getByText(label, { exact: true }) });
const key = (name) => `[data-key=${JSON.stringify(name)}]`;

describe('the page', { timeout: 600000 }, () => {
  afterEach(async () => {
    const { problems = [] } = opened ?? {};
    await opened?.close();
    opened = undefined;
    assert.deepEqual(problems, [], 'the browser complained');
  });
  after(closeBrowser);

  test('every plain value of the solid has a row with the schema’s default, limits and help', async () => {
    const { page } = await open();
    await page.locator('[data-section^="more.solids"] > h4 > button').click();
    const hidden = ['name', 'type', 'kind'];
    for (const [name, stated] of Object.entries(schema.$defs.lapped.properties)) {
      if (hidden.includes(name) || stated.$ref || stated.items) continue;
      const controls = page.locator(`[data-key="solids[0].${name}"], [data-key^="solids[0].${name}="]`);
      assert.ok((await controls.count()) > 0, `${name} has no control`);
      const first = controls.first(), role = await first.getAttribute('role');
      if (role === 'spinbutton') {
        assert.equal(Number(await first.inputValue()), stated.default, name);
        assert.deepEqual([await first.getAttribute('aria-valuemin'), await first.getAttribute('aria-valuemax')].map(Number), [stated.minimum, stated.maximum], name);
      } else if (role === 'switch') assert.equal(await first.isChecked(), stated.default, name);
      else assert.equal(await page.locator(`[data-key="solids[0].${name}=${stated.default}"]`).getAttribute('aria-checked'), 'true', name);
      const tip = await first.evaluate((element) => element.closest('.row').querySelector('[data-tip]').dataset.tip);
      assert.ok(tip.toLowerCase().includes(stated.description.slice(0, 25).toLowerCase()), `${name} says "${tip}"`);
    }
  });

  test('a drag of a slider is one step, and so is a burst of arrow keys; a double click goes back to the default', async () => {
    const { page, fake } = await open();
    const track = page.locator(key('solids[0].drop_off~')), box = await track.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + 10);
    await page.mouse.down();
    for (let i = 1; i <= 12; ++i) await page.mouse.move(box.x + box.width / 2 + i * 3, box.y + 10);
    await page.mouse.up();
    await eventually('the drag was sent', () => applied(fake).length === 1);
    const [drag] = applied(fake);
    assert.equal(drag.name, 'Set fill drop off');
    assert.equal(drag.operations[0].path, 'solids[0].drop_off');
    assert.ok(drag.operations[0].value > 0.075 && drag.operations[0].value <= 0.15);
    assert.equal(fake.document.solids[0].drop_off, drag.operations[0].value);

    await track.focus();
    for (let i = 0; i < 5; ++i) await page.keyboard.press('ArrowLeft');
    await eventually('the keys were sent', () => applied(fake).length === 2);
    await page.waitForTimeout(600);
    assert.equal(applied(fake).length, 2, 'five keys are one step');

    await track.dblclick();
    await eventually('the default is back', () => fake.document.solids[0].drop_off === undefined);
    const standard = schema.$defs.lapped.properties.drop_off.default;
    await eventually('the field shows it', async () => Number(await page.locator(key('solids[0].drop_off')).inputValue()) === standard);
    assert.equal(applied(fake).length, 3, 'the clicks of a double click are no steps of their own');
  });

  test('typed numbers are held within their limits, Escape gives them up, and a refusal brings back what was', async () => {
    const { page, fake } = await open();
    const field = page.locator(key('solids[0].angle_limit'));
    await field.click();
    await page.keyboard.type('500');
    await page.keyboard.press('Enter');
    await eventually('85 was set', () => fake.document.solids[0].angle_limit === 85);
    await settle(page);
    await field.click();
    await page.keyboard.type('20');
    await page.keyboard.press('Escape');
    assert.equal(await field.inputValue(), '85');
    await field.click();
    await page.keyboard.type('soup');
    await page.keyboard.press('Enter');
    assert.equal(await field.inputValue(), '85');
    assert.equal(applied(fake).length, 1);

    fake.revision += 1; // as if another page had been first
    await field.fill('30');
    await page.keyboard.press('Enter');
    await page.getByText('Another page changed the document first; it is shown now.').waitFor();
    assert.equal(await field.inputValue(), '85');
  });

  test('undo and redo go by button and key, and name the step', async () => {
    const { page, fake } = await open();
    await page.locator(key('solids[0].blend=variance')).click();
    await eventually('blend was set', () => fake.document.solids[0].blend === 'variance');
    await settle(page);
    const undo = page.locator(key('undo'));
    assert.equal(await undo.getAttribute('data-tip'), 'Undo: Set fill blend');
    await undo.click();
    await eventually('it was undone', () => fake.document.solids[0].blend === undefined);
    await settle(page);
    assert.equal(await page.locator(key('solids[0].blend=average')).getAttribute('aria-checked'), 'true');
    await page.locator('.viewport canvas').first().focus();
    await page.keyboard.press('Control+Shift+Z');
    await eventually('it was redone', () => fake.document.solids[0].blend === 'variance');
    await page.keyboard.press('Control+z');
    await eventually('it was undone by the key', () => fake.document.solids[0].blend === undefined);
    await settle(page);
    assert.equal(await undo.getAttribute('aria-disabled'), 'true');
    assert.equal(await undo.getAttribute('data-tip'), 'There is nothing to undo.');
  });

  test('the focus stays where it was when a list is built anew', async () => {
    const { page, fake } = await open(example('kiwi', (document) => { document.direction.strokes.push([[0, 0.2, -0.5], [0, 0.2, 0.5]]); }));
    await choose(page, { tab: 'fields' });
    await page.locator(key('direction 0')).focus();
    await page.keyboard.press('Enter');
    await eventually('a stroke was removed', () => fake.document.direction.strokes.length === 1);
    await settle(page);
    assert.equal(await page.evaluate(() => document.activeElement.dataset.key), 'direction 0');
  });

  test('the list of shortcuts is the keyboard: no key means two things, and each tool and command with a key is there', async () => {
    const { page } = await open();
    const { keys, labels } = await page.evaluate(() => {
      const { toolbox } = globalThis.pith, { commands } = globalThis.pith;
      return { keys: [...toolbox.tools.map((tool) => tool.key.toUpperCase()), ...commands.all.flatMap((command) => command.keys)],
               labels: [...toolbox.tools, ...commands.all.filter((command) => command.keys.length)].map((each) => each.label) };
    });
    assert.equal(new Set(keys).size, keys.length, `a key is there twice: ${keys.sort().join(' ')}`);
    await page.keyboard.press('?');
    const said = await page.locator('dialog dt').allTextContents();
    for (const label of labels) assert.ok(said.includes(label), `${label} is not listed`);
    const listed = await page.locator('dialog kbd').allTextContents();
    for (const each of keys) assert.ok(listed.includes(each), `${each} is not listed`);
    await page.keyboard.press('Escape');
    await page.locator('dialog').waitFor({ state: 'detached' });
    for (const [press, tool] of [['c', 'cut'], ['p', 'fill'], ['d', 'depth'], ['v', 'select']]) {
      await page.keyboard.press(press);
      assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), tool);
    }
    await page.keyboard.press('n');
    assert.equal(await page.locator('.inspector').isVisible(), false);
    await page.keyboard.press('n');
    assert.equal(await page.locator('.inspector').isVisible(), true);
  });

  test('letters typed into fields are no shortcuts', async () => {
    const { page, fake } = await open();
    await choose(page, { tab: 'look' });
    await page.locator(key('title')).fill('Chopped fruit');
    await page.keyboard.press('Enter');
    await eventually('the title was set', () => fake.document.title === 'Chopped fruit');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'select');
    assert.deepEqual(applied(fake).map((step) => step.name), ['Set title']);
  });

  test('a dialog keeps the focus, closes with Escape, and gives the focus back', async () => {
    const { page } = await open();
    const card = page.locator(key('type'));
    await card.focus();
    await page.keyboard.press('Enter');
    const dialog = page.locator('dialog[open]');
    await dialog.waitFor();
    for (let i = 0; i < 12; ++i) {
      await page.keyboard.press('Tab');
      assert.ok(await page.evaluate(() => document.activeElement === document.body || document.querySelector('dialog[open]').contains(document.activeElement)), 'the focus left the dialog');
    }
    await page.keyboard.press('c');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'select', 'a shortcut went through the dialog');
    await page.keyboard.press('Escape');
    await dialog.waitFor({ state: 'detached' });
    assert.equal(await page.evaluate(() => document.activeElement.dataset.key), 'type');
  });

  test('tools that a type has no use for say why and are not taken', async () => {
    const { page } = await open(example('sponge'));
    const fill = page.locator('.tool[aria-label="Fill faces"]');
    assert.equal(await fill.getAttribute('aria-disabled'), 'true');
    assert.match(await fill.getAttribute('data-tip'), /Type 0-A does not follow depth/);
    await page.keyboard.press('p');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'select');
    await page.locator('.message', { hasText: 'does not follow depth' }).waitFor();
    await page.keyboard.press('s');
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.tool), 'scale');
  });

  test('another texture type brings what it needs, in one step', async () => {
    const { page, fake } = await open();
    await page.keyboard.press('y');
    await page.locator('.type-option', { hasText: 'Even' }).click();
    await page.getByText('Adds a size to start from').waitFor();
    await page.locator('.check-label', { hasText: 'sponge' }).waitFor();
    await page.locator('dialog .button.main').click();
    await eventually('the type was set', () => fake.document.solids[0].type === '0-A');
    assert.equal(applied(fake).length, 1);
    assert.equal(fake.document.scale.points.length, 1);
    assert.deepEqual(fake.document.solids[0].exemplar, { recipe: 'exemplars/sponge.json' });
    await page.locator('dialog').waitFor({ state: 'detached' });
    await page.keyboard.press('Control+z');
    await eventually('all of it was undone', () => fake.document.solids[0].type === '1-B' && !fake.document.scale);
  });

  test('a body of nothing gets a solid, a core and directions', async () => {
    const { page, fake } = await open(example('kiwi', (document) => { delete document.solids; delete document.depth; delete document.direction; }), { built: false });
    await page.locator('.stage-card').getByText('no inside yet').waitFor();
    await page.locator('.stage-card .button.main').click();
    await page.locator('dialog .button.main').click();
    await eventually('there is a solid', () => fake.document.solids?.length === 1);
    const { solids: [solid], depth, direction } = fake.document;
    assert.equal(solid.type, '1-B');
    assert.equal(depth.constraints[0].faces, 'all');
    // The mesh is an ellipsoid of half height 1.25: its core ends a fifth of 2.5 before the poles.
    const core = depth.constraints[1].stroke.map((point) => point[2]).sort((a, b) => a - b);
    assert.ok(Math.abs(core[0] + 0.75) < 0.01 && Math.abs(core[1] - 0.75) < 0.01, String(core));
    assert.equal(direction.strokes.length, 1);
  });

  test('a recipe is copied into the document, and its stops are dragged, added and removed', async () => {
    const { page, fake } = await open();
    await page.locator('[data-section=recipe] > h3 > button').click();
    await page.locator(key('edit-copy')).click();
    await eventually('the recipe is in the document', () => fake.document.solids[0].exemplar.layered);
    const stops = () => fake.document.solids[0].exemplar.layered.stops, before = structuredClone(stops());
    const ramp = page.locator('.gradient');
    await ramp.scrollIntoViewIfNeeded();
    await settle(page);
    const box = await ramp.boundingBox(), third = page.locator(key('stop 5')), at = await third.boundingBox();
    await page.mouse.move(at.x + 7, at.y + 7);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.7 * box.width, at.y + 7, { steps: 6 });
    await page.mouse.up();
    await eventually('the stop moved', () => stops().some((stop) => Math.abs(stop.depth - 0.7) < 0.02));
    assert.deepEqual(stops().map((stop) => stop.depth), stops().map((stop) => stop.depth).sort((a, b) => a - b), 'stops stay in order');
    assert.deepEqual(new Set(stops().map((stop) => stop.colour)), new Set(before.map((stop) => stop.colour)));
    await settle(page);
    await ramp.click({ position: { x: 0.3 * box.width, y: 8 } });
    await eventually('a stop was added', () => stops().length === before.length + 1);
    const added = stops().find((stop) => Math.abs(stop.depth - 0.3) < 0.02);
    assert.match(added.colour, /^#[0-9a-f]{6}$/);
    await settle(page);
    await page.locator('.gradient-stop[data-chosen]').focus();
    await page.keyboard.press('Delete');
    await eventually('it was removed', () => stops().length === before.length);
    assert.ok(!stops().some((stop) => stop.depth === added.depth));
  });

  test('cuts are kept, changed and removed by their rows and keys', async () => {
    const { page, fake } = await open();
    await choose(page, { tab: 'cuts' });
    await page.locator(key('cuts[0].keep=both')).click();
    await eventually('both sides stay', () => fake.document.cuts[0].keep === 'both');
    await settle(page);
    await page.locator(key('cuts[0]')).click();
    await page.locator(key('cuts[0].gap')).click();
    await page.keyboard.type('0.25');
    await page.keyboard.press('Enter');
    await eventually('the gap was set', () => fake.document.cuts[0].gap === 0.25);
    await settle(page);
    assert.equal(await page.locator('[data-section=parts] .list-row').count(), 2);
    await page.locator(key('eye 1')).click();
    await eventually('a part was hidden', () => fake.document.parts?.[0].hidden);
    await eventually('the page has seen it', () => page.evaluate(() => globalThis.pith.model.parts.some((part) => part.hidden)));
    await page.locator('.viewport canvas').first().focus();
    await page.keyboard.press('Alt+h');
    await eventually('it is shown again', () => !fake.document.parts[0].hidden);
    await page.keyboard.press('Delete');
    await eventually('the chosen cut is gone', () => fake.document.cuts.length === 0);
    await page.getByText('Nothing is cut.').waitFor();
  });

  test('what is being made shows how far it is and can be cancelled; what is due is offered', async () => {
    const { page, fake } = await open(example('kiwi'), { delay: 4000 });
    const update = page.locator(key('update'));
    assert.equal(await update.getAttribute('aria-disabled'), 'true');
    await page.locator(key('solids[0].boundary=cut')).click();
    await eventually('an update is due', async () => (await update.getAttribute('aria-disabled')) === 'false');
    await page.locator('.badge', { hasText: 'Needs update' }).waitFor();
    await page.keyboard.press('u');
    const bar = page.locator('.job [role=progressbar]');
    await eventually('the bar moves', async () => Number(await bar.getAttribute('aria-valuenow')) >= 20);
    await page.locator('.job button').click();
    await page.locator('.job').waitFor({ state: 'hidden' });
    assert.ok(fake.asked.some((request) => request.do === 'cancel'));
  });

  test('saving over a file that another program changed is asked about', async () => {
    const { page, fake } = await open();
    await page.locator(key('solids[0].blend=variance')).click();
    await eventually('something changed', () => applied(fake).length === 1);
    await page.locator('.saved[data-saved=false]').waitFor();
    fake.changedOnDisk = true;
    await page.keyboard.press('Control+s');
    await page.locator('dialog').getByText('Save anyway', { exact: true }).click();
    await page.locator('.saved[data-saved=true]').waitFor();
    assert.deepEqual(fake.asked.filter((request) => request.do === 'save').map((request) => request.force ?? false), [false, true]);
    await page.keyboard.press('Control+s');
    await page.locator('dialog').getByText('Revert to the file', { exact: true }).click();
    await eventually('it went back', () => fake.asked.some((request) => request.do === 'revert'));
    await settle(page);
    fake.documents = [];              // somebody has removed the file
    await page.keyboard.press('Control+s');
    await page.locator('dialog').getByText('is not where it was').waitFor();
    assert.deepEqual(await page.locator('dialog footer button').allTextContents(), ['Cancel', 'Save anyway']);
    await page.keyboard.press('Escape');
  });

  test('a copy is saved under another name, which is said; what is refused is said beside the field', async () => {
    const { page, fake } = await open();
    const saves = () => fake.asked.filter((request) => request.do === 'save').map(({ file, force }) => ({ file, force }));
    await page.keyboard.press('Control+Shift+S');
    const dialog = page.locator('dialog[open]'), field = dialog.locator('input'), objection = dialog.locator('.objection');
    assert.equal(await field.inputValue(), 'kiwi.pith');
    await field.fill('  ');
    await page.keyboard.press('Enter');
    await objection.getByText('Type a name for the file.').waitFor();
    assert.deepEqual(saves(), []);
    await field.fill('tree');
    await page.keyboard.press('Enter');
    await objection.getByText('There is a file tree.pith already.').waitFor();
    assert.equal(await field.inputValue(), 'tree', 'the typed name is still there');
    await dialog.getByText('Replace', { exact: true }).click();
    await dialog.waitFor({ state: 'detached' });
    await page.locator('.message', { hasText: 'Saved tree.pith' }).waitFor();
    assert.deepEqual(saves(), [{ file: 'tree.pith', force: undefined }, { file: 'tree.pith', force: true }]);
    await page.keyboard.press('Control+Shift+S');
    await field.fill('plum.pith');
    await page.keyboard.press('Enter');
    await page.locator('.message', { hasText: 'Saved plum.pith' }).waitFor();
    assert.equal(await page.evaluate(() => globalThis.pith.store.state.file), 'kiwi.pith');
  });

  test('what would change nothing is no step', async () => {
    const { page, fake } = await open();
    await page.locator(key('solids[0].blend=variance')).click();
    await eventually('blend was set', () => fake.document.solids[0].blend === 'variance');
    await settle(page);
    await page.locator(key('solids[0].blend=variance')).click();
    await page.keyboard.press('Control+z');
    await eventually('it was undone', () => !fake.document.solids[0].blend);
    await settle(page);
    await page.locator('.viewport canvas').first().focus();
    await page.keyboard.press('Alt+h');
    await page.locator('.message', { hasText: 'Nothing is hidden.' }).waitFor();
    await page.keyboard.press('Control+Shift+Z');
    await eventually('it was redone', () => fake.document.solids[0].blend === 'variance');
    // A part that is just being hidden is shown again, though the page does not know yet that it is hidden.
    await page.evaluate(() => { globalThis.pith.store.set({ part: 0 }); globalThis.pith.commands.run('hide'); globalThis.pith.commands.run('show-all'); });
    await eventually('it is shown', () => fake.document.parts?.[0].hidden === false);
  });

  test('cuts that leave nothing say so and can be undone; so do hidden parts', async () => {
    const { page, fake } = await open();
    const cut = { op: 'cut.plane', plane: { point: [100, 0, 0], normal: [1, 0, 0] }, keep: 'positive' };
    await choose(page, { tool: 'cut' });
    await page.evaluate((cut) => globalThis.pith.actions.apply('Cut', [cut]), cut);
    const card = page.locator('.stage-card');
    await card.getByText('The cuts leave nothing of the model.').waitFor();
    assert.equal(await page.locator('[data-section=parts] .empty').textContent(), 'The cuts leave nothing.');
    await card.getByText('Undo', { exact: true }).click();
    await card.waitFor({ state: 'detached' });
    assert.equal(fake.document.cuts.length, 1);
    await page.evaluate(() => { globalThis.pith.store.set({ part: 0 }); globalThis.pith.commands.run('hide'); });
    await card.getByText('All parts are hidden.').waitFor();
    await card.getByText('Show all parts', { exact: true }).click();
    await card.waitFor({ state: 'detached' });
  });

  test('a lost connection is said, found again, and the page goes on', async () => {
    const { page, fake, problems } = await open();
    fake.drop();
    await page.locator('.banner.of-connection', { hasText: 'lost' }).waitFor();
    await page.locator('.banner.of-connection').waitFor({ state: 'hidden' });
    await page.locator(key('solids[0].blend=variance')).click();
    await eventually('a change went through', () => fake.document.solids[0].blend === 'variance');
    problems.length = 0; // the browser reports the broken socket
  });

  test('a server that has ended is told from one of another run', async () => {
    const { page, fake, problems, server } = await open();
    const banner = page.locator('.banner.of-connection'), port = Number(new URL(server.address).port);
    await server.stop();
    await banner.getByText('“pith edit” is not running; start it again').waitFor();
    await page.waitForTimeout(6000);   // as long as it used to take to be called an earlier run
    assert.match(await banner.textContent(), /is not running/);
    await server.start(port);
    await banner.waitFor({ state: 'hidden' });
    await settle(page);
    fake.token = 'another';
    fake.drop();
    await banner.getByText('This page belongs to an earlier run').waitFor();
    problems.length = 0;
  });

  test('that the view is not what the document says is said as long as it holds', async () => {
    const { page, fake } = await open();
    fake.viewWhy = 'cuts[1]: the stroke does not reach across the model';
    fake.tell(fake.event());
    const banner = page.locator('.banner.of-view', { hasText: 'does not reach across the model.' });
    await banner.waitFor();
    fake.viewWhy = null;
    fake.tell({ event: 'bodies', revision: fake.revision, bodies: fake.state().bodies, view: { why: null } });
    await banner.waitFor({ state: 'hidden' });
  });

  test('a message goes away after the focus has left it', async () => {
    const { page } = await open();
    await page.clock.install();
    await page.evaluate(() => globalThis.pith.messages.say('Soup.'));
    const message = page.locator('.message', { hasText: 'Soup.' });
    await message.locator('button').focus();
    await page.clock.runFor(20000);
    assert.equal(await message.count(), 1, 'it stays while it has the focus');
    await page.locator('.viewport canvas').first().focus();
    await page.clock.runFor(20000);
    assert.equal(await message.count(), 0);
  });

  test('a drag from the options of a tool selects no words', async () => {
    const { page } = await open();
    await choose(page, { tool: 'cut' });
    const bar = await page.locator('.tool-options').boundingBox();
    await page.mouse.move(bar.x + 4, bar.y + 4);
    await page.mouse.down();
    await page.mouse.move(bar.x + bar.width - 6, bar.y + bar.height - 4, { steps: 5 });
    await page.mouse.up();
    assert.equal(await page.evaluate(() => String(getSelection())), '');
  });

  test('the depth view of a body without depth says that there is none', async () => {
    const { page } = await open(example('sponge'));
    await choose(page, { mode: 'depth' });
    await page.locator('.depth-scale').getByText('This body has no depth.').waitFor();
    assert.equal(await page.locator('.scale-track').isVisible(), false);
    await choose(page, { mode: 'solid' });
    assert.equal(await page.locator('.depth-scale').isVisible(), false);
  });

  test('among the types of one kind the exemplar is offered too', async () => {
    const { page, fake } = await open(example('sponge'));
    await page.keyboard.press('y');
    await page.locator('.type-option', { has: page.getByText('Fibres', { exact: true }) }).click();
    const swap = page.locator('.check-label', { hasText: 'muscle' });
    await swap.waitFor();
    assert.equal(await swap.locator('input').isChecked(), true);
    await page.locator('dialog .button.main').click();
    await eventually('the type was set', () => fake.document.solids[0].type === '0-B');
    assert.deepEqual(fake.document.solids[0].exemplar, { recipe: 'exemplars/muscle.json' });
  });

  test('pictures are taken, shown and looked from again', async () => {
    const { page, fake } = await open();
    await page.evaluate(() => globalThis.pith.viewport.table.orbit(0.5, 0.1));
    const before = await page.evaluate(() => globalThis.pith.viewport.table.toDocument());
    await page.keyboard.press('Shift+P');
    await page.locator('.shot img').waitFor();
    const asked = fake.asked.find((request) => request.do === 'picture');
    assert.deepEqual([asked.width, asked.height, asked.how], [960, 720, 'render']);
    assert.deepEqual(asked.camera, before);
    await page.evaluate(() => globalThis.pith.viewport.table.orbit(1, 0.2));
    await page.locator('.shot-picture').click();
    const after = await page.evaluate(() => globalThis.pith.viewport.table.toDocument());
    before.eye.forEach((x, i) => assert.ok(Math.abs(x - after.eye[i]) < 1e-4));
  });

  test('a file dropped on the page goes beside the document and is offered as the exemplar', async () => {
    const { page, fake } = await open();
    await page.evaluate(() => {
      const dropped = new DataTransfer();
      dropped.items.add(new File(['{"stops": []}'], 'plum.json', { type: 'application/json' }));
      document.querySelector('.stage').dispatchEvent(new DragEvent('drop', { dataTransfer: dropped, bubbles: true, cancelable: true }));
    });
    await page.locator('.message', { hasText: 'plum.json is beside the document' }).getByText('Use it').click();
    await eventually('it is used', () => fake.document.solids[0].exemplar.recipe === 'plum.json');
    const put = fake.asked.find((request) => request.do === 'file.put');
    assert.deepEqual([put.name, put.bytes.toString()], ['plum.json', '{"stops": []}']);
  });

  test('an exemplar that cannot be read is not taken, and why is said', async () => {
    const { page, fake } = await open();
    fake.broken = ['broken.json'];
    const why = /line 3: ',' expected near 'stops'/;
    const drop = (selector) => page.evaluate((selector) => {
      const dropped = new DataTransfer();
      dropped.items.add(new File(['{'], 'broken.json', { type: 'application/json' }));
      document.querySelector(selector).dispatchEvent(new DragEvent('drop', { dataTransfer: dropped, bubbles: true, cancelable: true }));
    }, selector);
    await drop('.stage');
    await page.locator('.message', { hasText: 'broken.json is beside the document' }).getByText('Use it').click();
    await page.locator('.message', { hasText: why }).waitFor();
    await page.locator(key('replace')).click();
    const card = page.locator('.file', { hasText: 'broken' });
    await card.locator('.file-why', { hasText: why }).waitFor();
    await card.dispatchEvent('click');
    await drop('.drop');
    await page.locator('dialog .objection', { hasText: why }).waitFor();
    assert.equal(applied(fake).length, 0);
    await page.locator('.file', { hasText: 'cherry' }).click();
    await eventually('another is taken', () => fake.document.solids[0].exemplar.recipe === 'exemplars/cherry.json');
  });

  test('first steps are shown once', async () => {
    const { page } = await open(example('kiwi'), { hints: true });
    const steps = page.locator('.first-steps');
    await steps.getByText('Look inside').waitFor();
    await steps.getByText('Next').click();
    await steps.getByText('Next').click();
    await steps.getByText('Got it').click();
    assert.equal(await steps.isVisible(), false);
    await page.reload();
    await page.waitForFunction(() => globalThis.pith?.store.state.connection === 'open');
    assert.equal(await steps.isVisible(), false);
  });
});
