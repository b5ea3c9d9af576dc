// What the editor's page uses of diagram-js; tools/bundle-diagram makes views/vendor/diagram of it.
export { default as Diagram } from "diagram-js/lib/Diagram.js";
export { default as BaseRenderer } from "diagram-js/lib/draw/BaseRenderer.js";
export { default as BendpointsModule } from "diagram-js/lib/features/bendpoints/index.js";
export { default as ChangeSupportModule } from "diagram-js/lib/features/change-support/index.js";
export { default as LassoToolModule } from "diagram-js/lib/features/lasso-tool/index.js";
export { default as MoveModule } from "diagram-js/lib/features/move/index.js";
export { default as OutlineModule } from "diagram-js/lib/features/outline/index.js";
export { default as SnappingModule } from "diagram-js/lib/features/snapping/index.js";
export { default as MoveCanvasModule } from "diagram-js/lib/navigation/movecanvas/index.js";
export { default as ZoomScrollModule } from "diagram-js/lib/navigation/zoomscroll/index.js";
