// Where three.js (in NODE_PATH) puts the vertices of a .glb at some times, z up: node vertices.mjs FILE.glb "[0.1, 0.2]"
import fs from "fs";
const three = `${process.env.NODE_PATH}/three`;
const { AnimationMixer, Vector3 } = await import(`${three}/build/three.module.js`);
const { GLTFLoader } = await import(`${three}/examples/jsm/loaders/GLTFLoader.js`);
globalThis.self = globalThis;
const data = fs.readFileSync(process.argv[2]);
const { scene, animations } = await new GLTFLoader().parseAsync(data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength), "");
const mixer = new AnimationMixer(scene);
mixer.clipAction(animations[0]).play();
const found = JSON.parse(process.argv[3]).map((t) => {
  mixer.setTime(t); scene.updateMatrixWorld(true);
  const places = {};
  scene.traverse((node) => {
    if (!node.isMesh) return;
    const { position } = node.geometry.attributes, at = (k) => new Vector3().fromBufferAttribute(position, k).applyMatrix4(node.matrixWorld);
    places[node.name] = Array.from({ length: position.count }, (_, k) => at(k)).map(({ x, y, z }) => [x, -z, y]);
  });
  return places;
});
console.log(JSON.stringify(found));
