// Shows a photographed room in a scene of three.js, with a red ball before its walls and a blue one in the next room,
// half behind the frame of the door.
import {AmbientLight, Color, DirectionalLight, Mesh, MeshStandardMaterial, PerspectiveCamera, Scene, SphereGeometry,
  Vector3, WebGLRenderer} from 'three';
import {LumatlasObject} from 'lumatlas/three';

const renderer = new WebGLRenderer({antialias: true});
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);

const scene = new Scene();
scene.background = new Color(0x203040);
scene.add(new AmbientLight(0xffffff, 1.5), new DirectionalLight(0xffffff, 2));

const camera = new PerspectiveCamera(50, innerWidth / innerHeight, 0.05, 100);
const model = await LumatlasObject.load('/model/', renderer);
// The model's own upwards becomes three's.
model.quaternion.setFromUnitVectors(new Vector3(...model.modelUp), new Vector3(0, 1, 0));
model.updateMatrixWorld();
model.placeCamera(camera);
scene.add(model);

function ball(color: number, ahead: number, right: number): Mesh {
  const mesh = new Mesh(new SphereGeometry(0.4, 48, 24), new MeshStandardMaterial({color, roughness: 0.4}));
  mesh.position.set(right, 0, -ahead).applyMatrix4(camera.matrixWorld);
  scene.add(mesh);
  return mesh;
}

camera.updateMatrixWorld();
const balls = {before: ball(0xff2200, 2.5, -0.7), behind: ball(0x0044ff, 6, 1.2)};

renderer.setAnimationLoop(() => renderer.render(scene, camera));
Object.assign(window, {example: {renderer, scene, camera, model, balls}});
