// What the pages use of three.js and uPlot: bundled once, into vendor.js, which both pages load before their own
// program. A page imports it as "vendor".

export {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, CapsuleGeometry, Color,
  CylinderGeometry, DirectionalLight, DoubleSide, FrontSide, GridHelper, Group, HemisphereLight, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshLambertMaterial, PerspectiveCamera, Plane, PlaneGeometry, Quaternion,
  Raycaster, SRGBColorSpace, Scene, SphereGeometry, Spherical, Sprite, SpriteMaterial, Vector2, Vector3, WebGLRenderer, WireframeGeometry,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { LineMaterial } from "three/addons/lines/LineMaterial.js";
export { LineSegments2 } from "three/addons/lines/LineSegments2.js";
export { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
export { default as uPlot } from "uplot";
