// The scene in space: surfaces, light, receiver, curves, and the rays that bring the light. Loaded when it is
// first asked for.
import {
  AmbientLight, ArrowHelper, Box3, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, EdgesGeometry, Group,
  LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshPhongMaterial, Object3D, PerspectiveCamera,
  PlaneGeometry, Quaternion, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { cividis, placeOf } from "../colours";
import type { Json, Reading, Vec2, Vec3 } from "../contract";
import { h } from "../dom";
import { get, isObject } from "../pointer";
import { add, dot, inWorld, length, minus, receiverOf, scaled, thingsOf, toPlane, unit, vec3, type Receiver } from "../scene";
import type { State, Store } from "../state";
import { clippingExpressions, clippingPlanes } from "./apertures";
import { linesOf } from "./lines";
import { cutMesh, type Mesh as Triangles } from "./mesh";
import { meshOf } from "./shapes";

const ANGLE = Math.PI / 24; // of an arrow key
const DISTANCE = 2.8; // of the eye, in reaches of the scene
const GRID = 3; // arrows of a beam, each way

export class Space {
  private readonly canvas = h("canvas", {
    class: "space", tabindex: 0, role: "img",
    "aria-label": "The scene in space. Drag or arrow keys turn it, + and − come nearer and go away.",
  });
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 1000);
  private readonly controls = new OrbitControls(this.camera, this.canvas);
  private readonly scene = new Scene();
  private readonly bodies = this.group();
  private readonly curves = this.group();
  private readonly rays = this.group();
  private frame = 0;
  private placed = "";

  /** `point` hears which point of the receiver is under the pointer. */
  constructor(
    private readonly store: Store,
    private readonly parent: HTMLElement,
    point: (uv: Vec2 | null) => void,
  ) {
    parent.append(this.canvas);
    this.renderer.localClippingEnabled = true;
    this.camera.up.set(0, 0, 1);
    const lamp = new DirectionalLight(0xffffff, 1.6);
    lamp.position.set(0.4, 0.6, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera, new AmbientLight(0xffffff, 0.9));
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) point(this.pointed(event));
    });
    this.canvas.addEventListener("pointerleave", () => point(null));
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
    store.watch(["request"], (state) => this.showBodies(state));
    store.watch(["traced"], (state) => this.showCurves(state));
    store.watch(["reading", "fan"], (state) => this.showRays(state));
    store.watch(["stressed"], ({ stressed }) => this.stress(stressed));
    new MutationObserver(() => this.recolour()).observe(document.documentElement, { attributeFilter: ["data-theme"] });
  }

  // ---- What is seen ----------------------------------------------------------------------------------

  private showBodies({ request }: State): void {
    clear(this.bodies);
    const receiver = receiverOf(request);
    if (!receiver) return;
    const reach = reachOf(request, receiver);
    this.bodies.add(receiverBody(receiver, this.ink("--faint")));
    const surfaces = get(request, "/scene/surfaces");
    const bodies = (Array.isArray(surfaces) ? surfaces : [])
      .map((surface) => (isObject(surface) ? surfaceBody(surface, reach) : null))
      .filter((body) => body !== null);
    this.bodies.add(...bodies, ...lightBodies(request, receiver, this.ink("--light")));
    this.canvas.dataset["bodies"] = String(bodies.length);
    this.canvas.dataset["triangles"] = String(bodies.reduce((sum, body) => sum + body.geometry.index!.count / 3, 0));
    this.aim(receiver, bodies);
    this.draw();
  }

  private showCurves({ traced }: State): void {
    clear(this.curves);
    const receiver = traced && receiverOf(traced.request);
    if (!receiver) return;
    const side = Math.max(...receiver.size);
    const world = ([u, v]: Vec2) => add(receiver.origin, inWorld(receiver, u, v, 0));
    const of = (kind: string, level: number | null) =>
      traced.curves.features
        .filter((f) => f.properties.kind === kind && (level === null || f.properties.level === level))
        .map((f) => f.geometry.coordinates.map(world));
    const levels = [...new Set(traced.curves.features.map((f) => f.properties.level))].filter((l): l is number => l !== null && l > 0);
    const place = placeOf(levels);
    for (const level of levels) {
      const lines = linesOf(of("isolux", level), { colour: cividis(place(level)), width: 2 });
      lines.userData["level"] = level;
      this.curves.add(lines, linesOf(of("jump", level), { colour: this.ink("--faint"), width: 1 }));
    }
    this.curves.add(linesOf(of("caustic", null), { colour: this.ink("--ink"), width: 1.4, dash: side / 60 }));
    this.canvas.dataset["curves"] = String(traced.curves.features.length);
    this.draw();
  }

  /** Of the meter's reading, and of the curve that was picked. */
  private showRays({ reading, fan, request }: State): void {
    clear(this.rays);
    const receiver = receiverOf(request);
    if (!receiver) return;
    const paths = [...(fan ?? []), ...(reading ? [reading] : [])];
    const lines = paths.flatMap((point) => raysOf(point, request, receiver));
    if (lines.length) this.rays.add(linesOf(lines, { colour: this.ink("--light"), width: 1.2, opacity: fan ? 0.55 : 0.9 }));
    this.canvas.dataset["rays"] = String(lines.length);
    this.draw();
  }

  private stress(level: number | null): void {
    for (const object of this.curves.children as (Object3D & { material: { linewidth: number } })[]) {
      const own = object.userData["level"] as number | undefined;
      if (own === undefined) continue;
      object.material.linewidth = own === level ? 4.5 : level === null ? 2 : 1.2;
    }
    this.draw();
  }

  // ---- The eye ---------------------------------------------------------------------------------------

  /** Only when the scene's place changes: what is dragged should not carry the eye along. */
  private aim(receiver: Receiver, bodies: Mesh[]): void {
    const key = JSON.stringify([receiver.origin, receiver.size]);
    if (key === this.placed) return;
    this.placed = key;
    const box = extentOf(this.store.now.request, receiver, bodies);
    const middle = box.getCenter(new Vector3()).toArray() as Vec3;
    const reach = box.getSize(new Vector3()).length() / 2;
    const up = Math.sign(dot(minus(middle, receiver.origin), receiver.normal)) || 1;
    const side: Vec3 = unit(add(add(scaled(receiver.u, 0.7), scaled(receiver.v, -1)), scaled(receiver.normal, 0.75 * up)));
    this.camera.position.set(...add(middle, scaled(side, (DISTANCE * reach) / Math.min(1, this.camera.aspect))));
    this.camera.near = reach / 200;
    this.camera.far = reach * 50;
    this.controls.target.set(...middle);
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  private pointed(event: PointerEvent): Vec2 | null {
    const receiver = receiverOf(this.store.now.request);
    if (!receiver) return null;
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    const { origin, direction } = caster.ray;
    const normal = new Vector3(...receiver.normal);
    const distance = new Vector3(...receiver.origin).sub(origin).dot(normal) / direction.dot(normal);
    if (!(distance > 0)) return null;
    return toPlane(receiver, origin.clone().addScaledVector(direction, distance).toArray() as Vec3);
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-ANGLE, 0], ArrowRight: [ANGLE, 0], ArrowUp: [0, ANGLE], ArrowDown: [0, -ANGLE],
    };
    const turn = turns[event.key];
    const zoom = { "+": 0.85, "=": 0.85, "-": 1 / 0.85 }[event.key] ?? 1;
    if (!turn && zoom === 1) return;
    event.preventDefault();
    const arm = this.camera.position.clone().sub(this.controls.target).multiplyScalar(zoom);
    if (turn) {
      const right = new Vector3().crossVectors(this.camera.up, arm).normalize();
      arm.applyAxisAngle(right, -turn[1]).applyAxisAngle(this.camera.up, turn[0]);
    }
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
    this.draw();
  }

  // ---- Drawing ---------------------------------------------------------------------------------------

  private group(): Group {
    const group = new Group();
    this.scene.add(group);
    return group;
  }

  private ink = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  private recolour(): void {
    this.showBodies(this.store.now);
    this.showCurves(this.store.now);
    this.showRays(this.store.now);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  private draw(): void {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.renderer.render(this.scene, this.camera);
    });
  }
}

/** What ends by itself. */
const BOUNDED = ["sphere", "ellipsoid", "torus", "revolution", "expression"];

// ---- Bodies ------------------------------------------------------------------------------------------

function clear(group: Group): void {
  group.traverse((object) => {
    const { geometry, material } = object as Partial<Mesh>;
    geometry?.dispose();
    for (const one of Array.isArray(material) ? material : [material]) one?.dispose();
  });
  group.clear();
}

function surfaceBody(surface: { [key: string]: Json }, reach: number): Mesh | null {
  const shape = surface["shape"];
  const whole = isObject(shape) ? meshOf(shape, reach) : null;
  if (!whole) return null;
  const cuts = clippingExpressions(surface);
  const mesh = cuts.reduce(cutMesh, posed(whole, poseOf(surface)));
  if (!mesh.indices.length) return null;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(mesh.positions), 3));
  geometry.setIndex(mesh.indices);
  geometry.computeVertexNormals();
  const kind = get(surface, "/optics/type");
  const glass = kind === "refract";
  const material = new MeshPhongMaterial({
    color: kind === "absorb" ? 0x33353c : glass ? 0x7fa6c9 : 0x9aa3b5,
    shininess: kind === "absorb" ? 5 : 90,
    side: DoubleSide,
    transparent: true,
    opacity: glass ? 0.4 : 0.85,
    depthWrite: !glass,
    clippingPlanes: clippingPlanes(surface),
  });
  const body = new Mesh(geometry, material);
  const cut = cuts.length + material.clippingPlanes!.length > 0;
  body.userData["bounded"] = cut || BOUNDED.includes(String(get(surface, "/shape/type")));
  return body;
}

function poseOf(surface: Json): Matrix4 {
  const axis = unit(vec3(get(surface, "/pose/rotate/axis")) ?? [0, 0, 1]);
  const angle = (Number(get(surface, "/pose/rotate/degrees") ?? 0) * Math.PI) / 180;
  const shift = vec3(get(surface, "/pose/translate")) ?? [0, 0, 0];
  const turn = new Quaternion().setFromAxisAngle(new Vector3(...axis), angle);
  return new Matrix4().compose(new Vector3(...shift), turn, new Vector3(1, 1, 1));
}

function posed({ positions, indices }: Triangles, pose: Matrix4): Triangles {
  const points = new BufferAttribute(new Float64Array(positions), 3).applyMatrix4(pose);
  return { positions: [...points.array], indices };
}

function receiverBody({ origin, u, v, normal, size }: Receiver, colour: string): Group {
  const geometry = new PlaneGeometry(...size);
  const group = new Group();
  const face = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.13, side: DoubleSide, depthWrite: false });
  group.add(new Mesh(geometry, face), new LineSegments(new EdgesGeometry(geometry), new LineBasicMaterial({ color: colour })));
  const [x, y, z] = [u, v, normal].map((e) => new Vector3(...e));
  group.applyMatrix4(new Matrix4().makeBasis(x!, y!, z!).setPosition(...origin));
  return group;
}

function lightBodies(request: { [key: string]: Json }, receiver: Receiver, colour: string): Object3D[] {
  const light = thingsOf(request).find((thing) => thing.kind !== "surface");
  if (!light) return [];
  const size = Math.max(...receiver.size);
  if (light.kind === "light") {
    const ball = new Mesh(new SphereGeometry(size / 70, 24, 16), new MeshBasicMaterial({ color: colour }));
    ball.position.set(...light.at);
    return [ball];
  }
  const way = unit(light.at);
  const long = 0.3 * size;
  return Array.from({ length: GRID * GRID }, (_, i) => {
    const [a, b] = [(i % GRID) / (GRID - 1) - 0.5, Math.floor(i / GRID) / (GRID - 1) - 0.5];
    const on = add(receiver.origin, inWorld(receiver, 0.5 * a * size, 0.5 * b * size, 0));
    const from = add(on, scaled(way, -reachOf(request, receiver)));
    return new ArrowHelper(new Vector3(...way), new Vector3(...from), long, colour, 0.15 * long, 0.08 * long);
  });
}

/** Light, hits, receiver; a beam comes from far away. */
function raysOf(reading: Reading, request: { [key: string]: Json }, receiver: Receiver): Vec3[][] {
  const light = thingsOf(request).find((thing) => thing.kind !== "surface");
  const end = add(receiver.origin, inWorld(receiver, reading.uv[0], reading.uv[1], 0));
  return reading.sheets.flatMap(({ vertices }) => {
    if (!light) return [];
    const first = vertices[0] ?? end;
    const start = light.kind === "light" ? light.at : add(first, scaled(unit(light.at), -reachOf(request, receiver)));
    return [[start, ...vertices, end]];
  });
}

/** A box around receiver, light and what of the surfaces has an end. */
function extentOf(request: { [key: string]: Json }, receiver: Receiver, bodies: Mesh[]): Box3 {
  const box = new Box3();
  const [w, h] = receiver.size;
  for (const [u, v] of [[-w, -h], [w, -h], [w, h], [-w, h]])
    box.expandByPoint(new Vector3(...add(receiver.origin, inWorld(receiver, u! / 2, v! / 2, 0))));
  for (const thing of thingsOf(request)) if (thing.kind !== "beam") box.expandByPoint(new Vector3(...thing.at));
  for (const { geometry, material, userData } of bodies) {
    if (!userData["bounded"]) continue;
    const planes = (material as MeshPhongMaterial).clippingPlanes ?? [];
    const points = geometry.getAttribute("position");
    const point = new Vector3();
    for (let i = 0; i < points.count; ++i) {
      point.fromBufferAttribute(points, i);
      if (planes.every((plane) => plane.distanceToPoint(point) >= 0)) box.expandByPoint(point);
    }
  }
  return box;
}

/** How far from the receiver's centre the scene goes on. */
function reachOf(request: { [key: string]: Json }, receiver: Receiver): number {
  const far = thingsOf(request)
    .filter((thing) => thing.kind !== "beam")
    .map((thing) => length(minus(thing.at, receiver.origin)));
  return 1.1 * Math.max(Math.hypot(...receiver.size) / 2, ...far);
}
