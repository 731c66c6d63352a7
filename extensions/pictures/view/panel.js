// Panel of the page of a run, above that of k3d. `K3DInstance` is the plot; scene.py makes its customData.
const run = K3DInstance.parameters.customData;
const font = document.createElement('style');
// numbers and names along the axes are set as mathematics otherwise, title and clock in the font of the browser
font.textContent = '.k3d-target, .katex, .katex * { font-family: Verdana, "DejaVu Sans", sans-serif !important; }';
document.head.append(font);
K3DInstance.gui.domElement.style.setProperty('--width', 'min(270px, 70vw)');
K3DInstance.gui.domElement.style.setProperty('--name-width', '33%');  // names of fields and cuts are longer than their keys
K3DInstance.gui.domElement.style.setProperty('--slider-input-width', '36%');
const objects = Object.values(K3DInstance.getWorld().ObjectsListJson);
const nearest = (time) => run.times.reduce((a, b) => (Math.abs(b - time) < Math.abs(a - time) ? b : a));
const state = {
    field: run.fields[0],
    cut: run.cut,
    at: 0,
    keep: 'far side',
    play() { K3DInstance.autoPlayed ? K3DInstance.stopAutoPlay() : K3DInstance.startAutoPlay(); },
};
const panel = K3DInstance.gui.addFolder('View');
K3DInstance.gui.$children.prepend(panel.domElement);

function showField() {
    objects.filter((one) => run.fields.includes(one.group)).forEach((one) => {
        one.visible = one.group === state.field;
        K3DInstance.reload(one, null, true);
    });
}
function cut() {
    const plane = run.cuts[state.cut];
    const side = state.keep === 'far side' ? 1 : -1;
    K3DInstance.setClippingPlanes(plane ? [[...plane.slice(0, 3).map((one) => side * one), -side * state.at]] : []);
}
function chooseCut() {
    const plane = run.cuts[state.cut];
    place.show(Boolean(plane));
    keep.show(Boolean(plane));
    if (plane) {
        state.at = plane[5];
        place.min(plane[3]).max(plane[4]).updateDisplay();
    }
    cut();
}
panel.add(state, 'field', run.fields).onChange(showField);
panel.add(K3DInstance.parameters, 'time', 0, run.times.at(-1) || 1).name('time (µs)').decimals(1).listen()
    .onChange((time) => K3DInstance.setTime(nearest(time)));
panel.add(state, 'play').name('play / stop');
panel.add(state, 'cut', ['none', ...Object.keys(run.cuts)]).onChange(chooseCut);
const place = panel.add(state, 'at', -1, 1).name('cut at (mm)').decimals(1).onChange(cut);
const keep = panel.add(state, 'keep', ['far side', 'near side']).onChange(cut);
chooseCut();
K3DInstance.setTime(K3DInstance.parameters.time);
if (innerWidth < run.phone_width) {
    K3DInstance.gui.close();  // it would hide the packing
    const places = { title: [0.01, 0.05], clock: [0.5, 0.14] };  // below the panel, and each other
    objects.filter((one) => one.name in places).forEach((one) => {
        const position = one.position.data || one.position;
        [position[0], position[1]] = places[one.name];
        K3DInstance.reload(one, null, true);
    });
}
const narrow = Math.max(1, innerHeight / innerWidth);  // the field of view is that of the height
const target = run.camera.slice(3, 6);
const position = target.map((middle, n) => middle + narrow * (run.camera[n] - middle));
const camera = [...position, ...run.camera.slice(3)];
// again, now that all is there: numbers along the axes are hidden otherwise
K3DInstance.setCamera(camera);
setTimeout(() => { K3DInstance.setCamera(camera); K3DInstance.render(); }, 50);  // k3d sets its own after 10 ms
K3DInstance.render();
