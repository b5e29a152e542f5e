// The program on a free port and a browser that reports whatever the page does wrong.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";
import { chromium } from "playwright-core";

const folder = mkdtempSync(join(tmpdir(), "isocaustic-browser-"));

/** Starts the program; its address, once it listens. */
export function serve(options = []) {
  const program = spawn(process.env.ISOCAUSTIC_PROGRAM, ["serve", "--port", "0", "--data", folder, "--log", "off", ...options]);
  return new Promise((resolve, reject) => {
    let said = "";
    const listen = (bytes) => {
      said += bytes;
      const address = said.match(/listening on (http:\/\/\S+)/);
      if (address) resolve({ program, base: address[1] });
    };
    program.stdout.on("data", listen);
    program.stderr.on("data", listen);
    program.on("exit", () => reject(new Error(`the program ended: ${said}`)));
  });
}

/** One server and one browser for the tests of a file. */
export function useBrowser(options = []) {
  const world = { base: "", faults: [] };
  let program, browser;
  before(async () => {
    ({ program, base: world.base } = await serve(options));
    const root = process.getuid() === 0; // where Chromium has no sandbox
    const args = ["--enable-unsafe-swiftshader", ...(root ? ["--no-sandbox"] : [])]; // draws WebGL without a GPU
    browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args });
  });
  after(async () => {
    await browser?.close();
    program?.removeAllListeners("exit");
    program?.kill();
    rmSync(folder, { recursive: true, force: true });
    if (world.faults.length) throw new Error(world.faults.join("\n"));
  });
  // Pages of a file share what the browser keeps, for one the little pictures.
  const contexts = new Map();
  const contextFor = async (options) => {
    const key = JSON.stringify(options);
    if (!contexts.has(key)) {
      contexts.set(key, await browser.newContext(options));
      await contexts.get(key).grantPermissions(["clipboard-read", "clipboard-write"]);
    }
    return contexts.get(key);
  };
  /** A new page; what it may not do fails the file. */
  world.open = async (path, { width = 1280, height = 800, pictures = false, ...more } = {}) => {
    const page = await (await contextFor(more)).newPage();
    await page.setViewportSize({ width, height });
    // Little pictures of all examples take a second of computing; few tests are about them.
    const wanted = path.match(/#example=(.*)/)?.[1] ?? "torus";
    if (!pictures)
      await page.route(/\/v1\/examples\/./, (route) =>
        route.request().url().endsWith(`/${wanted}`) ? route.continue() : route.abort());
    page.on("pageerror", (error) => world.faults.push(`pageerror: ${error.stack}`));
    page.on("console", (message) => {
      if (/Content Security Policy|violates/.test(message.text())) world.faults.push(message.text());
    });
    page.on("request", (request) => {
      if (!/^(data|blob):/.test(request.url()) && !request.url().startsWith(world.base))
        world.faults.push(`asked elsewhere: ${request.url()}`);
    });
    await page.goto(world.base + path);
    return page;
  };
  return world;
}

/** The exact curves of what is asked now are shown. */
export async function settled(page) {
  await page.waitForSelector('.diagram[data-settled="true"]');
}

/** After something that changes the request. */
export async function settledAfter(page, change) {
  const before = await page.getAttribute(".diagram", "data-updates");
  await change();
  await page.waitForFunction(
    (n) => {
      const { updates, settled: done } = document.querySelector(".diagram").dataset;
      return done === "true" && updates !== n;
    },
    before,
  );
}

/** All paths of one class as one text: what the diagram shows. */
export const drawn = (page, name = "isolux") =>
  page.$$eval(`.curves path.${name}`, (paths) => paths.map((path) => path.getAttribute("d")).join());

export const field = (page, label, nth = 0) => page.getByLabel(label, { exact: true }).nth(nth);
