// The upload under way: how far, what failed and why, and how to go on.
import { useStudio } from '../../state'
import { Bar } from '../../bar'
import { bytes, count } from '../../words'
import { cancel, headOf, leave, send } from './upload'
import type { Failed, Upload } from './upload'

function FailedList({ failed }: { failed: Failed[] }) {
  return (
    <section class="make-failed" aria-label="Photographs that were not taken">
      <h3>Not taken</h3>
      <ul>
        {failed.map((one, i) => (
          <li key={i}>
            <code>
              {one.pose}/{one.photo.name}
            </code>
            <span>{one.why}</span>
          </li>
        ))}
      </ul>
    </section>
  )
}

export function Sending({ upload }: { upload: Upload }) {
  const { tell } = useStudio()
  const { state, failed, left } = upload
  const share = upload.bytesTotal > 0 ? upload.bytesSent / upload.bytesTotal : 0
  const again = [...failed, ...left]
  const go = () => {
    leave()
    location.hash = '#/run'
    tell('Press Run, at the top right: it makes all steps of the new project.')
  }
  return (
    <section class="make-sending" aria-label="Photographs on their way">
      <h2>{headOf(upload)}</h2>
      <Bar label="Photographs sent" share={share} />
      <div class="row spread number">
        <span>
          {upload.sent - failed.length} of {count(upload.total, 'photograph')}
        </span>
        <span class="soft">
          {bytes(upload.bytesSent)} of {bytes(upload.bytesTotal)}
        </span>
      </div>
      <p class="soft small now">{upload.now}</p>
      {left.length > 0 && (
        <p>{count(left.length, 'photograph')} not sent. What was sent is kept.</p>
      )}
      {failed.length > 0 && <FailedList failed={failed} />}
      <div class="row">
        {state === 'sending' && <button onClick={cancel}>Cancel</button>}
        {state !== 'sending' && again.length > 0 && (
          <button class={left.length > 0 ? 'main' : ''} onClick={() => void send(again)}>
            {left.length > 0 ? 'Send the rest' : 'Try these again'}
          </button>
        )}
        {state !== 'sending' && (
          <button class={left.length > 0 ? '' : 'main'} onClick={go}>
            Go on to Run
          </button>
        )}
      </div>
    </section>
  )
}
