// The scene in the address: an example by its name, anything else packed into the fragment, which is sent to
// nobody. And the same request for a shell and for Python.
import type { ContourRequest } from "./contract";
import { prettyJson } from "./json_text";
import { isObject } from "./pointer";
import type { Store } from "./state";
import { token } from "./token";

const WAIT_MS = 300; // browsers allow a hundred changes of the address in half a minute

async function through(bytes: BlobPart, stream: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function packed(request: ContourRequest): Promise<string> {
  const bytes = await through(JSON.stringify(request), new CompressionStream("deflate-raw"));
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

export async function unpacked(text: string): Promise<ContourRequest> {
  const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(raw, (c) => c.charCodeAt(0));
  const value: unknown = JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"))));
  if (!isObject(value as ContourRequest)) throw new Error("not a request");
  return value as ContourRequest;
}

/** What the address asks for: an example, a scene, or nothing. */
export async function fromAddress(): Promise<{ example: string } | { request: ContourRequest } | null> {
  const [key, value] = location.hash.slice(1).split("=", 2);
  if (key === "example" && value) return { example: decodeURIComponent(value) };
  if (key === "scene" && value) return { request: await unpacked(value) };
  return null;
}

let written = "";

export function keepInAddress(store: Store, load: () => void): void {
  let timer = 0;
  const write = async () => {
    const { example, request } = store.now;
    written = example ? `#example=${encodeURIComponent(example)}` : `#scene=${await packed(request)}`;
    if (request === store.now.request && location.hash !== written) history.replaceState(null, "", written);
  };
  store.watch(["request", "dragging"], ({ dragging }) => {
    clearTimeout(timer);
    if (!dragging) timer = window.setTimeout(() => void write(), WAIT_MS);
  });
  window.addEventListener("hashchange", () => {
    if (location.hash !== written) load();
  });
}

export function asCurl(request: ContourRequest): string {
  const json = prettyJson(request).replaceAll("'", "'\\''");
  const secret = token() ? ' \\\n  -H "Authorization: Bearer $ISOCAUSTIC_TOKEN"' : "";
  return `curl -s --json '${json}'${secret} \\\n  ${location.origin}/v1/contours\n`;
}

export function asPython(request: ContourRequest): string {
  const json = prettyJson(request).replaceAll("\\", "\\\\").replaceAll('"""', '\\"\\"\\"');
  const secret = token() ? `, "Authorization": "Bearer " + os.environ["ISOCAUSTIC_TOKEN"]` : "";
  return `import json${token() ? ", os" : ""}, urllib.request

BASE = "${location.origin}"
HEADERS = {"Content-Type": "application/json"${secret}}

def call(path, body=None):
    data = None if body is None else json.dumps(body).encode()
    with urllib.request.urlopen(urllib.request.Request(BASE + path, data, HEADERS)) as answer:
        return answer.read()

request = json.loads("""${json}""")
answer = json.loads(call("/v1/contours", request))
for curve in answer["curves"]:
    print(curve["kind"], curve["level"], curve["vertices"])
with open("curves.vtp", "wb") as file:
    file.write(call(answer["files"]["vtp"]))
`;
}

/** Also where the page is not from a secure origin, and browsers keep the clipboard to themselves. */
export async function copy(text: string): Promise<void> {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  document.execCommand("copy");
  area.remove();
}
