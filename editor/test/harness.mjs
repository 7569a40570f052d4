// What the page's tests stand on: the real program on a copy of a document, and Debian's Chromium, which draws WebGL 2 in
// software. Each test has a server, a folder and a page of its own.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, basename } from 'node:path';
import { after, afterEach, beforeEach } from 'node:test';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

export const root = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
export const program = process.env.PITH ?? join(root, 'build', 'pith');
const pageFolder = process.env.PITH_PAGE ?? join(root, 'build', 'editor');

let browser;
/** One browser for all tests of a file. */
export async function openBrowser() {
  browser ??= await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-background-networking',
           '--disable-component-update', '--disable-sync', '--no-first-run', '--disable-quic'],
  });
  return browser;
}
export async function closeBrowser() {
  await browser?.close();
  browser = undefined;
}

/** A folder with a copy of examples/ (documents, recipes) and of data/, as documents expect them. */
export function workFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'pith-editor-'));
  cpSync(join(root, 'examples'), join(folder, 'examples'), { recursive: true, filter: (path) => !path.endsWith('.pithc') });
  cpSync(join(root, 'data'), join(folder, 'data'), { recursive: true });
  return folder;
}

/** Starts `pith edit` and resolves when it has said its address. */
export function startServer(document, options = []) {
  const child = spawn(program, ['edit', document, '--no-open', '--json', '--page', pageFolder, ...options],
                      { stdio: ['ignore', 'pipe', 'pipe'] });
  let errors = '';
  child.stderr.on('data', (text) => { errors += text; });
  return new Promise((resolve, reject) => {
    let text = '';
    child.stdout.on('data', (more) => {
      text += more;
      let said;
      try { said = JSON.parse(text); } catch { return; } // not all of it yet
      resolve({ child, address: said.address, document, errors: () => errors, stop: (signal = 'SIGTERM') => stopServer(child, signal) });
    });
    child.on('exit', (code) => reject(new Error(`pith edit ended with ${code}: ${errors}`)));
  });
}

function stopServer(child, signal) {
  return new Promise((resolve) => {
    if (child.exitCode !== null || child.signalCode !== null) return resolve(child.exitCode);
    child.once('exit', (code) => resolve(code));
    child.kill(signal);
  });
}

/** Opens the page; resolves when the view of a built model has been drawn (or at once with `built` false). */
export async function openPage(server, { built = true, width = 1280, height = 800, theme = 'dark' } = {}) {
  const context = await (await openBrowser()).newContext({ viewport: { width, height }, colorScheme: theme });
  const page = await context.newPage();
  const problems = [];
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('console', (message) => { if (message.type() === 'error') problems.push(message.text()); });
  page.on('request', (request) => { if (!request.url().startsWith(new URL(server.address).origin) && !/^(blob|data):/.test(request.url())) problems.push(`asked for ${request.url()}`); });
  await page.addInitScript(() => localStorage.setItem('pith.hints', 'seen'));
  await page.goto(server.address);
  await page.waitForFunction(() => globalThis.pith?.store.state.connection === 'open');
  if (built) await settled(page);
  return { page, problems, context, close: () => context.close() };
}

/** What each test of a suite works at: a folder of its own, and the document that it opens there. Made inside `describe`;
 *  after each test page and server are ended before the page's complaints are looked at. */
export class Desk {
  constructor() {
    beforeEach(() => { this.folder = workFolder(); });
    afterEach(async () => {
      const problems = this.opened?.problems ?? [];
      await this.opened?.close();
      await this.server?.stop();
      rmSync(this.folder, { recursive: true, force: true });
      this.opened = this.server = undefined;
      assert.deepEqual(problems, [], 'the page complained');
    });
    after(closeBrowser);
  }

  /** Opens the document at a path, with the options of openPage; gives the page. */
  async open(path, options) {
    this.server = await startServer(path);
    this.opened = await openPage(this.server, options);
    return this.opened.page;
  }

  /** Opens a document of examples/, changed first if asked. */
  openExample(name, change, options) {
    const path = join(this.folder, 'examples', name);
    if (change) {
      const text = readDocument(path);
      change(text);
      writeFileSync(path, JSON.stringify(text));
    }
    return this.open(path, options);
  }
}

/** Until every job has ended, the view shows the present document, and its picture has been drawn. */
export async function settled(page, timeout = 60000) {
  await page.waitForFunction(() => {
    const { store, viewport } = globalThis.pith, { state } = store;
    const busy = state.jobs.some((job) => job.state === 'waiting' || job.state === 'running');
    return !busy && viewport.view && !viewport.view.bare && state.bodies.every((body) => body.shown);
  }, undefined, { timeout, polling: 50 });
  await drawn(page);
}

/** Until two frames have gone by: whatever changed has been drawn. */
export function drawn(page) {
  return page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))));
}

/** Pixels of the view as they are now: [r, g, b, a] at CSS points of the view. */
export function pixels(page, points) {
  return page.evaluate(async (at) => {
    const { viewport } = globalThis.pith;
    const image = await createImageBitmap(await viewport.picture());
    const canvas = new OffscreenCanvas(image.width, image.height), brush = canvas.getContext('2d');
    brush.drawImage(image, 0, 0);
    const scale = image.width / viewport.element.clientWidth;
    return at.map(([x, y]) => [...brush.getImageData(Math.round(x * scale), Math.round(y * scale), 1, 1).data]);
  }, points);
}

/** Where the view lies on the page. */
export function viewBox(page) {
  return page.evaluate(() => { const b = globalThis.pith.viewport.element.getBoundingClientRect(); return { x: b.x, y: b.y, width: b.width, height: b.height }; });
}

/** Drags the mouse through points of the view. */
export async function drag(page, points, { button = 'left', steps = 6, keys = [] } = {}) {
  const box = await viewBox(page);
  for (const key of keys) await page.keyboard.down(key);
  await page.mouse.move(box.x + points[0][0], box.y + points[0][1]);
  await page.mouse.down({ button });
  for (const [x, y] of points.slice(1)) await page.mouse.move(box.x + x, box.y + y, { steps });
  await page.mouse.up({ button });
  for (const key of keys) await page.keyboard.up(key);
}

export async function click(page, x, y, options = {}) {
  const box = await viewBox(page);
  await page.mouse.click(box.x + x, box.y + y, options);
}

export const state = (page) => page.evaluate(() => globalThis.pith.store.state);
export const readDocument = (path) => JSON.parse(readFileSync(path, 'utf8'));
export { basename, cpSync, existsSync, join, readFileSync, rmSync, writeFileSync };
