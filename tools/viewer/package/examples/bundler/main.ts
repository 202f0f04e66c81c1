// Makes an element by script, with buttons that go to photographs and a picture of the view.
import 'lumatlas';

const main = document.querySelector('main')!;
const viewer = document.createElement('lumatlas-viewer');
viewer.setAttribute('background', 'white');
viewer.addEventListener('error', ({detail}) => console.error(detail.message));
main.append(viewer);

function button(text: string, action: () => Promise<void>): void {
  const made = document.createElement('button');
  made.textContent = text;
  made.addEventListener('click', action);
  main.append(made);
}

async function takePicture(): Promise<void> {
  const image = new Image(240);
  image.src = URL.createObjectURL(await viewer.screenshot());
  main.append(image);
}

await viewer.load('/model/');
for (const name of viewer.views.slice(0, 4)) button(name, () => viewer.goTo(name, {duration: 500}));
button('Closer', async () => {
  const {position, direction} = viewer.camera;
  await viewer.goTo({position: position.map((p, axis) => p + 0.3 * direction[axis])});
});
button('Take a picture', takePicture);
