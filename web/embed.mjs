// node embed.mjs DIST OUTPUT.h
// Writes what Vite built as a C++ table: where each file is served, its type, and its bytes compressed.
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { extname, join } from "node:path";
import { gzipSync } from "node:zlib";

const TYPES = {
  ".css": "text/css; charset=utf-8",
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".svg": "image/svg+xml",
};
// What has an address of its own; all else is served as it is called.
const ADDRESSES = { "/index.html": "/", "/docs.html": "/docs" };

const [dist, output] = process.argv.slice(2);

function* filesIn(folder, path = "") {
  for (const name of readdirSync(folder).sort()) {
    const file = join(folder, name);
    if (statSync(file).isDirectory()) yield* filesIn(file, `${path}/${name}`);
    else yield [`${path}/${name}`, readFileSync(file)];
  }
}

// Three octal digits end the escape, so what follows cannot become part of it.
const escaped = (bytes) => {
  let text = "";
  for (let i = 0; i < bytes.length; ++i) {
    const byte = bytes[i];
    const plain = byte >= 32 && byte < 127 && byte !== 34 && byte !== 63 && byte !== 92;
    text += plain ? String.fromCharCode(byte) : `\\${byte.toString(8).padStart(3, "0")}`;
    if (i % 96 === 95) text += '"\n    "';
  }
  return text;
};

let rows = "";
for (const [name, bytes] of filesIn(dist)) {
  const type = TYPES[extname(name)];
  if (!type) throw new Error(`${name}: of no known type`);
  const packed = gzipSync(bytes, { level: 9 });
  const tag = createHash("sha256").update(bytes).digest("hex").slice(0, 32);
  rows += `    {"${ADDRESSES[name] ?? name}", "${type}", "${tag}", ${bytes.length}, `;
  rows += `std::string_view("${escaped(packed)}", ${packed.length})},\n`;
}
writeFileSync(
  output,
  `// Made by web/embed.mjs.\n#pragma once\n\nnamespace caustic::service {\n\n` +
    `constexpr PageFile kPageFiles[] = {\n${rows}};\n\n}  // namespace caustic::service\n`,
);
