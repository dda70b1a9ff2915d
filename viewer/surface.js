// One surface: plain, coloured, with a checkerboard or with its texture; its vertices can be moved.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, MeshLambertMaterial, RepeatWrapping, SRGBColorSpace,
  TextureLoader, Vector3,
} from "three";

const SQUARES = 9; // of the checkerboard along the longest side of the source

export class Surface {
  constructor(data) {
    this.data = data;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(data.positions.slice(), 3));
    geometry.setIndex(new BufferAttribute(data.triangles, 1));
    if (data.origins) geometry.setAttribute("origin", new BufferAttribute(data.origins, 4));
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    const material = new MeshLambertMaterial({ side: DoubleSide });
    this.squares = { value: 0 };
    if (data.origins) {
      material.onBeforeCompile = (shader) => {
        shader.uniforms.squares = this.squares;
        shader.vertexShader = "attribute vec4 origin; varying vec4 vOrigin;\n" +
          shader.vertexShader.replace("#include <begin_vertex>", "#include <begin_vertex>\nvOrigin = origin;");
        shader.fragmentShader = "uniform float squares; varying vec4 vOrigin;\n" +
          shader.fragmentShader.replace("#include <color_fragment>", `#include <color_fragment>
            if (squares > 0.0 && vOrigin.w > 0.999) {
              vec3 cell = floor(vOrigin.xyz * squares);
              if (mod(cell.x + cell.y + cell.z, 2.0) > 0.5) diffuseColor.rgb *= 0.45;
            }`);
      };
    }
    this.mesh = new Mesh(geometry, material);
    this.textured = null;
  }

  // Colours (three bytes per vertex) or null for plain; a `texture` replaces both.
  paint(colours, checker, texture) {
    const { geometry, material } = this.mesh;
    if (colours) {
      const linear = new Float32Array(colours.length);
      const colour = new Color();
      for (let i = 0; i < linear.length; i += 3) {
        colour.setRGB(colours[i] / 255, colours[i + 1] / 255, colours[i + 2] / 255, SRGBColorSpace).toArray(linear, i);
      }
      geometry.setAttribute("color", new BufferAttribute(linear, 3));
    } else geometry.deleteAttribute("color");
    this.squares.value = checker ? SQUARES : 0;
    material.vertexColors = Boolean(colours);
    material.needsUpdate = true;
    if (texture && !this.textured) this.#addTextured(texture);
    this.mesh.visible = !texture;
    if (this.textured) this.textured.visible = Boolean(texture);
  }

  // A copy whose triangles share no corners, so that each corner has its own texture coordinates.
  #addTextured(texture) {
    const { uv, triangles } = this.data;
    // Faces with texture coordinates first; the others are grey.
    const faces = [...uv.known.keys()].sort((i, j) => uv.known[j] - uv.known[i]);
    const corners = faces.flatMap((face) => [3 * face, 3 * face + 1, 3 * face + 2]);
    const known = 3 * uv.known.reduce((sum, known) => sum + known, 0);
    const geometry = new BufferGeometry();
    geometry.setAttribute("uv", new BufferAttribute(
      Float32Array.from({ length: 2 * corners.length }, (_, i) => uv.coordinates[2 * corners[i >> 1] + (i & 1)]), 2));
    for (const name of ["position", "normal"]) {
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * corners.length), 3));
    }
    geometry.addGroup(0, known, 0);
    geometry.addGroup(known, corners.length - known, 1);
    this.corners = corners.map((corner) => triangles[corner]);
    this.textured = new Mesh(geometry, [
      new MeshLambertMaterial({ map: texture, side: DoubleSide }),
      new MeshLambertMaterial({ color: 0x737378, side: DoubleSide }),
    ]);
    this.textured.frustumCulled = false;
    this.mesh.parent.add(this.textured);
    this.#updateTextured();
  }

  #updateTextured() {
    for (const name of ["position", "normal"]) {
      const from = this.mesh.geometry.getAttribute(name).array;
      const to = this.textured.geometry.getAttribute(name);
      this.corners.forEach((vertex, i) => to.array.set(from.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
      to.needsUpdate = true;
    }
  }

  // The normal at the vertex nearest to a point.
  normal(point) {
    const { position, normal } = this.mesh.geometry.attributes;
    const at = new Vector3();
    let nearest = 0, smallest = Infinity;
    for (let i = 0; i < position.count; i++) {
      const distance = at.fromBufferAttribute(position, i).distanceToSquared(point);
      if (distance < smallest) [nearest, smallest] = [i, distance];
    }
    return at.fromBufferAttribute(normal, nearest);
  }

  move(positions) {
    const { geometry } = this.mesh;
    geometry.getAttribute("position").array.set(positions);
    geometry.getAttribute("position").needsUpdate = true;
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    if (this.textured) this.#updateTextured();
  }
}

export function textureOf(address, done) {
  const texture = new TextureLoader().load(address, done);
  texture.colorSpace = SRGBColorSpace;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.anisotropy = 4;
  return texture;
}
