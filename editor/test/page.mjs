// The page on the server that builds nothing: for tests of everything around the view.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { startFake } from './fake.mjs';
import { openBrowser, root } from './harness.mjs';

const folder = process.env.PITH_PAGE ?? join(root, 'build', 'editor');

/** A document of examples/, changed first if asked. */
export function example(name, change) {
  const document = JSON.parse(readFileSync(join(root, 'examples', `${name}.pith`)));
  change?.(document);
  return document;
}

/** Opens the page on a document; `problems` gathers what the browser complains of. */
export async function openFake(document, { width = 1280, height = 800, theme = 'dark', touch = false, hints = false, ...options } = {}) {
  const server = await startFake(folder, document, options);
  const context = await (await openBrowser()).newContext({ viewport: { width, height }, colorScheme: theme, reducedMotion: 'reduce', hasTouch: touch, isMobile: touch });
  const page = await context.newPage(), problems = [];
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('console', (message) => { if (message.type() === 'error') problems.push(message.text()); });
  await page.addInitScript((hints) => { if (!hints) localStorage.setItem('pith.hints', 'seen'); }, hints);
  const close = async () => { await context.close(); await server.stop(); };
  try {
    await page.goto(server.address);
    await page.waitForFunction(() => globalThis.pith?.store.state.connection === 'open' && globalThis.pith.viewport.view);
    await settle(page);
  } catch (reason) {
    await close();                    // a server left behind would keep the tests from ending
    throw reason;
  }
  return { page, problems, server, fake: server.fake, close };
}

/** Until what was asked for has been answered and shown. */
export async function settle(page) {
  await page.evaluate(() => globalThis.pith.actions.try(Promise.resolve()).then(() => new Promise((resolve) => setTimeout(resolve, 60))));
}

/** The changes the page asked for: names of steps with their operations. */
export const applied = (fake) => fake.asked.filter((request) => request.do === 'apply').map(({ name, operations }) => ({ name, operations }));

/** Sets what the page alone has chosen. */
export async function choose(page, values) {
  await page.evaluate((values) => globalThis.pith.store.set(values), values);
  await settle(page);
}

/** Waits until something holds here; says what did not. */
export async function eventually(what, test, timeout = 20000) {
  for (const end = Date.now() + timeout; !(await test());) {
    if (Date.now() > end) throw new Error(`it did not come to pass that ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
}
