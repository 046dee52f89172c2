// One page on how to photograph, for who has never done it.
import type { ComponentChildren } from 'preact'

import {
  BackdropDrawing,
  FrameDrawing,
  LightDrawing,
  MatDrawing,
  RingsDrawing,
  StepsDrawing,
} from './drawings'

function Rule(props: { name: string; drawing: ComponentChildren; children: ComponentChildren }) {
  return (
    <section class="guide-rule">
      {props.drawing}
      <div>
        <h2>{props.name}</h2>
        {props.children}
      </div>
    </section>
  )
}

const kWrong: [string, string][] = [
  ['It shines, or is one colour', 'Matt it with powder or spray; press in texture, or paint spots. Eyes of glass may stay.'],
  ['It moved between photographs', 'Fasten it, turn slowly, let it come to rest. What sways is not found twice in one place.'],
  ['Blurred', 'Use a tripod and a remote release or the timer. Small aperture, f/8 to f/11, so that front and back are sharp.'],
  ['Bright here, dark there', 'Switch everything automatic off. No daylight that changes, no flash on the camera.'],
  ['A hand, a tool, a second figure', 'Leave such a photograph out, on the page Poses.'],
  ['Cut off by the frame', 'Leave air on all sides, also where an arm comes round.'],
  ['A hole below, between the legs', 'A second ring from above, or below; or lay the figure down and photograph it once more.'],
]

export function Guide() {
  return (
    <main class="guide" tabIndex={0}>
      <article>
        <header>
          <h1>How to photograph</h1>
          <p class="soft">
            A telephone will do, a camera with manual settings is better. A ring of photographs takes
            ten minutes; each of these rules saves an hour later.
          </p>
        </header>
        <div class="guide-rules">
          <Rule name="Soft light that stays" drawing={<LightDrawing />}>
            <p>
              Two large lamps behind paper or cloth, from both sides. No hard shadow on figure or
              table, no window.
            </p>
          </Rule>
          <Rule name="The figure turns" drawing={<RingsDrawing />}>
            <p>
              Camera on a tripod, figure on a turntable. One ring at its eye height, a second from 30
              degrees above.
            </p>
            <p>Lock focus, exposure, white balance and zoom.</p>
          </Rule>
          <Rule name="24 to 36 in a ring" drawing={<StepsDrawing />}>
            <p>
              10 to 15 degrees apart, so that each place is in at least three. More is slower, not
              better.
            </p>
            <p>A further pose of the same figure: six, evenly round.</p>
          </Rule>
          <Rule name="Fill the frame" drawing={<FrameDrawing />}>
            <p>
              The whole figure in each photograph, two thirds of its height. Do not zoom or move the
              camera between poses.
            </p>
          </Rule>
          <Rule name="A plain backdrop" drawing={<BackdropDrawing />}>
            <p>
              Matt paper of another colour than the figure, half a metre behind it. Nothing else
              stands in the picture.
            </p>
          </Rule>
          <Rule name="Or a printed mat" drawing={<MatDrawing />}>
            <p>
              Below the figure, it gives true size, and helps where clay is smooth.{' '}
              <a href="/api/door/board" download>
                Take it
              </a>{' '}
              and print it at 100 %, on A4.
            </p>
          </Rule>
        </div>
        <h2 class="guide-wrong">What goes wrong</h2>
        <table>
          <tbody>
            {kWrong.map(([what, cure]) => (
              <tr key={what}>
                <td>{what}</td>
                <td>{cure}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </article>
    </main>
  )
}
