#!/bin/sh
# Make three.min.js, the parts of three.js that page.js uses, with npm: sh skancf/output/web/build.sh 0.187.0
set -eu
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
cd "$folder"
npm install --silent "three@$1" esbuild@0.28.2
cat > parts.js <<'PARTS'
export { BufferAttribute, BufferGeometry, DataTexture, DoubleSide, LinearFilter, LineBasicMaterial, LineSegments, Mesh,
         OrthographicCamera, Raycaster, Scene, ShaderMaterial, Sphere, Vector2, Vector3, WebGLRenderer } from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
PARTS
{
    echo "/*! three.js $1, https://threejs.org. Bundled by build.sh. */"
    echo "/*!"
    cat node_modules/three/LICENSE
    echo "*/"
    npx esbuild parts.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none
} > "$here/three.min.js"
rm -r "$folder"
