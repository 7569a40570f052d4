// Can it be read, named, reached and touched? Contrast of every text in both themes (WCAG 2.2, 1.4.3), names of every
// control (4.1.2), nothing cut off at the least size, and targets large enough for fingers.
import assert from 'node:assert/strict';
import { after, afterEach, describe, test } from 'node:test';
import { closeBrowser } from './harness.mjs';
import { choose, example, openFake, settle } from './page.mjs';

let opened;

const twoCuts = (document) => document.cuts.push({ stroke: { eye: [0, -8, 0], points: [[-1.5, 0, 0.3], [1.5, 0, -0.2]] }, keep: 'both', gap: 0.2 });

/* The page in each of its states; `visit` is called in every one. */
async function tour(page, visit) {
  const close = async () => { await page.keyboard.press('Escape'); await page.locator('dialog').waitFor({ state: 'detached' }); };
  await visit('start');
  await choose(page, { tool: 'fill', mode: 'depth', paint: 0.5, layer: 0.35 });
  await visit('painting');
  await choose(page, { tool: 'paste', mode: 'solid', layer: null });
  await visit('pasting');
  await choose(page, { tool: 'cut', chosenCut: 1, part: 0 });
  await visit('cutting');
  await choose(page, { tool: 'select', tab: 'look', chosenCut: null, part: null });
  await page.locator('[data-section=volume] > h3 > button').click();
  await visit('pictures');
  await choose(page, { tab: 'inside' });
  await page.locator('[data-section=recipe] > h3 > button').click();
  await page.locator('[data-key=edit-copy]').click();
  await page.locator('.gradient').waitFor();
  await page.locator('[data-key="solids[0].exemplar.layered.noises[1]"]').click();
  await visit('recipe');
  await page.evaluate(() => {
    const { messages, store } = globalThis.pith;
    messages.say('A refusal of some length, which names a place and a remedy.', 'warning');
    messages.say('Saved kiwi.pith.', 'done');
    store.set({ connection: 'lost', jobs: [{ event: 'job', job: 99, what: 'solid', state: 'running', fraction: 0.4, text: 'Filling' }] });
  });
  await settle(page);
  await visit('messages');
  await choose(page, { connection: 'open', jobs: [] });
  await page.locator('.title').click();
  await visit('menu');
  await page.keyboard.press('Escape');
  await page.evaluate(() => globalThis.pith.commands.run('type'));
  await page.getByText('Keep', { exact: true }).waitFor();
  await page.locator('.type-option', { hasText: 'Even' }).click();
  await settle(page);
  await visit('types');
  await close();
  await page.evaluate(() => globalThis.pith.commands.run('shortcuts'));
  await visit('shortcuts');
  await close();
  await page.evaluate(() => globalThis.pith.commands.run('save-as'));
  await visit('save as');
  await close();
}

/* Texts whose contrast with what lies behind them is too small, as "text: ratio". Runs in the page. */
function poorContrast() {
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  canvas.canvas.width = canvas.canvas.height = 1;
  const rgba = (text) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = text;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], [R, G, B]) => [r * a + R * (1 - a), g * a + G * (1 - a), b * a + B * (1 - a), 1];
  const linear = (x) => (x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const ratio = (a, b) => { const [x, y] = [light(a), light(b)].sort((p, q) => q - p); return (x + 0.05) / (y + 0.05); };
  const style = getComputedStyle(document.documentElement), stages = ['--canvas-near', '--canvas-far'].map((name) => rgba(style.getPropertyValue(name)));
  /* All colours that may lie behind an element: one, or both ends of the view's gradient. */
  const behind = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      if (at.classList.contains('stage')) return stages.map((stage) => layers.reduceRight((below, layer) => over(layer, below), stage));
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour[3] === 0) continue;
      layers.push(colour);
      if (colour[3] === 1) break;
    }
    return [layers.reduceRight((below, layer) => over(layer, below), [0, 0, 0, 1])];
  };
  const top = document.querySelector('dialog[open]') ?? document.body, poor = [];
  const walker = document.createTreeWalker(top, NodeFilter.SHOW_TEXT);
  const texts = [];
  for (let node; (node = walker.nextNode());) if (node.textContent.trim()) texts.push([node.parentElement, node.textContent.trim()]);
  for (const input of top.querySelectorAll('input[type=text], select')) texts.push([input, input.value]);
  for (const [element, text] of texts) {
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) || element.closest('[disabled], [aria-disabled=true], .off, noscript, option')) continue;
    const { color, fontSize, fontWeight } = getComputedStyle(element), large = parseFloat(fontSize) >= 24 || (parseFloat(fontSize) >= 18.66 && fontWeight >= 700);
    const least = Math.min(...behind(element).map((back) => ratio(over(rgba(color), back), back)));
    if (!(least >= (large ? 3 : 4.5))) poor.push(`${text.slice(0, 40)}: ${least.toFixed(2)}`);
  }
  return { poor, count: texts.length };
}

/* Controls that say nothing to a screen reader. Runs in the page. */
function nameless() {
  const top = document.querySelector('dialog[open]') ?? document.body;
  const named = (element) => {
    const by = element.getAttribute('aria-labelledby')?.split(' ').map((id) => document.getElementById(id)?.textContent ?? '').join(' ');
    const label = element.labels ? [...element.labels].map((each) => each.textContent).join(' ') : '';
    return (element.getAttribute('aria-label') || by || label || (element.matches('input, select') ? '' : element.textContent)).trim();
  };
  return [...top.querySelectorAll('button, input, select, [role=slider], [role=radiogroup], [role=tablist], [role=separator], [role=progressbar], canvas[tabindex], dialog')]
    .filter((element) => element.checkVisibility() && element.type !== 'file' && element.tagName !== 'HR' && !named(element)).map((element) => element.outerHTML.slice(0, 160));
}

/* What reaches beyond the window, or beyond a box that neither scrolls nor shortens it. Runs in the page. */
function cutOff() {
  const wide = document.documentElement.clientWidth, high = document.documentElement.clientHeight, found = [];
  if (document.documentElement.scrollWidth > wide) found.push(`the page is ${document.documentElement.scrollWidth} wide`);
  for (const element of document.querySelectorAll('.page button, .page input, .page select, dialog[open] button')) {
    if (!element.checkVisibility() || element.closest('.inspector-scroll, .dialog-body, .toolstrip')) continue;
    const box = element.getBoundingClientRect();
    if (box.left < -1 || box.top < -1 || box.right > wide + 1 || box.bottom > high + 1) found.push(`${element.getAttribute('aria-label') ?? element.textContent} at ${Math.round(box.left)}, ${Math.round(box.top)}`);
  }
  const inspector = document.querySelector('.inspector-scroll');
  if (inspector.checkVisibility() && inspector.scrollWidth > inspector.clientWidth + 1) found.push(`the inspector is ${inspector.scrollWidth} wide in ${inspector.clientWidth}`);
  return found;
}

/* Controls of the top bar that lie over one another. Runs in the page. */
function crossed() {
  const all = [...document.querySelectorAll('.topbar button, .topbar label, .topbar .progress')].filter((each) => each.checkVisibility()), found = [];
  const said = (element) => element.getAttribute('aria-label') ?? element.textContent;
  all.forEach((one, i) => all.slice(i + 1).forEach((other) => {
    const a = one.getBoundingClientRect(), b = other.getBoundingClientRect();
    const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0.5;
    if (over) found.push(`${said(one)} and ${said(other)}`);
  }));
  return found.concat(all.filter((each) => each.getBoundingClientRect().width < 8).map((each) => `${said(each)} has no width`));
}

describe('looks', { timeout: 900000 }, () => {
  afterEach(async () => { await opened?.close(); opened = undefined; });
  after(closeBrowser);

  for (const theme of ['dark', 'light']) {
    test(`every text of the ${theme} page can be read, and every control has a name`, async () => {
      opened = await openFake(example('kiwi', twoCuts), { theme, hints: true });
      let texts = 0;
      await tour(opened.page, async (place) => {
        const { poor, count } = await opened.page.evaluate(poorContrast);
        texts += count;
        assert.deepEqual(poor, [], `${place}: too little contrast`);
        assert.deepEqual(await opened.page.evaluate(nameless), [], `${place}: controls without a name`);
      });
      assert.ok(texts > 400, `only ${texts} texts were looked at`);
    });
  }

  test('nothing is cut off in the least window', async () => {
    opened = await openFake(example('kiwi', twoCuts), { width: 900, height: 600 });
    await tour(opened.page, async (place) => assert.deepEqual(await opened.page.evaluate(cutOff), [], place));
  });

  test('in a narrow window the inspector is a drawer over the view', async () => {
    opened = await openFake(example('kiwi'), { width: 700, height: 700 });
    const { page } = opened, inspector = page.locator('.inspector');
    assert.equal(await inspector.isVisible(), false);
    const stage = await page.locator('.stage').boundingBox();
    await page.locator('[data-key=inspector]').click();
    await inspector.waitFor();
    assert.equal((await page.locator('.stage').boundingBox()).width, stage.width, 'the view keeps its width');
    assert.deepEqual(await page.evaluate(cutOff), []);
  });

  const working = [{ event: 'job', job: 99, what: 'solid', state: 'running', fraction: 0.4, text: 'Filling with patches' }];

  for (const touch of [false, true]) {
    test(`no two controls of the top bar ${touch ? 'of a touch screen ' : ''}lie over one another, however narrow the window`, async () => {
      opened = await openFake(example('kiwi', (document) => { document.title = 'A kiwi with a rather long title'; }), { touch });
      const { page } = opened;
      for (const width of [320, 400, 560, 640, 720, 800, 820, 900, 1024, 1280]) {
        await page.setViewportSize({ width, height: 700 });
        for (const jobs of [[], working]) {
          await choose(page, { jobs });
          assert.deepEqual(await page.evaluate(crossed), [], `${width} pixels wide, ${jobs.length} jobs`);
          assert.deepEqual(await page.evaluate(cutOff), [], `${width} pixels wide, ${jobs.length} jobs`);
        }
      }
    });
  }

  test('the options of every tool lie inside the view of a narrow window', async () => {
    opened = await openFake(example('kiwi', twoCuts), { width: 400, height: 700 });
    const { page } = opened;
    for (const width of [320, 400, 640]) {
      await page.setViewportSize({ width, height: 700 });
      for (const tool of ['cut', 'plane', 'fill', 'face', 'depth', 'points', 'direction', 'paste']) {
        await choose(page, { tool });
        const beyond = await page.evaluate(() => {
          const bar = document.querySelector('.tool-options'), { left, right } = bar.getBoundingClientRect();
          return [...bar.querySelectorAll('button, input, select, .number-box')].map((each) => [each, each.getBoundingClientRect()])
            .filter(([, box]) => box.left < left || box.right > right).map(([each, box]) => `${each.outerHTML.slice(0, 90)} at ${box.left} to ${box.right} of ${left} to ${right}`);
        });
        assert.deepEqual(beyond, [], `${tool} at ${width}`);
        assert.deepEqual(await page.evaluate(cutOff), [], `${tool} at ${width}`);
      }
    }
  });

  test('what is said of the connection leaves the options of the tool free', async () => {
    opened = await openFake(example('kiwi'), { width: 800 });
    const { page } = opened;
    for (const connection of ['lost', 'gone', 'refused']) {
      await choose(page, { tool: 'cut', connection });
      const banner = await page.locator('.banner.of-connection').boundingBox(), bar = await page.locator('.tool-options').boundingBox();
      assert.ok(bar.y >= banner.y + banner.height, `${connection}: the banner ends at ${banner.y + banner.height}, the bar begins at ${bar.y}`);
    }
    await choose(page, { connection: 'open' });
  });

  test('fingers find targets of 36 pixels or more', async () => {
    opened = await openFake(example('kiwi', twoCuts), { width: 1100, height: 760, touch: true });
    const { page } = opened;
    await tour(page, async (place) => {
      const small = await page.evaluate(() => [...document.querySelectorAll('button, select, input, [role=slider]')].filter((element) => {
        if (!element.checkVisibility() || element.matches('.gradient-stop, .row-reset') || element.type === 'file') return false;
        const target = element.closest('label, .number-box') ?? element, box = target.getBoundingClientRect();
        return box.height > 0 && Math.min(box.height, box.width) < 35.5;
      }).map((element) => `${element.className} ${element.getAttribute('aria-label') ?? element.textContent} ${element.getBoundingClientRect().width}x${element.getBoundingClientRect().height}`));
      assert.deepEqual(small, [], place);
    });
  });

  test('the theme is the system’s until one is chosen, and the choice is remembered', async () => {
    opened = await openFake(example('kiwi'), { theme: 'light' });
    const { page } = opened, theme = () => page.evaluate(() => document.documentElement.dataset.theme);
    assert.equal(await theme(), 'light');
    await page.emulateMedia({ colorScheme: 'dark' });
    await page.reload();
    await page.locator('.page').waitFor();
    assert.equal(await theme(), 'dark');
    await page.locator('[data-key=theme]').click();
    assert.equal(await theme(), 'light');
    await page.reload();
    await page.locator('.page').waitFor();
    assert.equal(await theme(), 'light');
  });

  test('who asks for less motion gets none', async () => {
    opened = await openFake(example('kiwi'));
    const moving = await opened.page.evaluate(() => [...document.querySelectorAll('*')].filter((element) => {
      const { animationName, transitionDuration } = getComputedStyle(element);
      return animationName !== 'none' || transitionDuration.split(', ').some((time) => parseFloat(time) > 0);
    }).map((element) => element.className));
    assert.deepEqual(moving, []);
  });
});
