// The bus access layer of a board. Source: VCI V3 .NET manual 4.1; the vendor's published contract of Ixxat.Vci4.
using System;
using System.Collections.Generic;
using System.Linq;
using Canwire.Native;

#if VCI3
namespace Ixxat.Vci3.Bal
#else
namespace Ixxat.Vci4.Bal
#endif
{
    using Can;
    using Lin;

    internal sealed unsafe class BalObject : Disposable, IBalObject
    {
        private static readonly Dictionary<Type, Func<BalResource, BalResource>> canKinds =
            new Dictionary<Type, Func<BalResource, BalResource>> {
                { typeof(ICanSocket), at => new CanSocket(at) },
                { typeof(ICanControl), at => new CanControl(at) },
                { typeof(ICanChannel), at => new CanChannel(at) },
                { typeof(ICanScheduler), at => new CanScheduler(at) },
#if !VCI3
                { typeof(ICanSocket2), at => new CanSocket2(at) },
                { typeof(ICanControl2), at => new CanControl2(at) },
                { typeof(ICanChannel2), at => new CanChannel2(at) },
                { typeof(ICanScheduler2), at => new CanScheduler2(at) },
#endif
            };

        private static readonly Dictionary<Type, Func<BalResource, BalResource>> linKinds =
            new Dictionary<Type, Func<BalResource, BalResource>> {
                { typeof(ILinSocket), at => new LinSocket(at) },
                { typeof(ILinControl), at => new LinControl(at) },
                { typeof(ILinMonitor), at => new LinMonitor(at) },
            };

        private readonly NativeObject layer;
        private readonly Version firmware;
        private readonly BalResource[] resources;

        internal BalObject(IntPtr layer)
        {
            BalFeatures features;
            this.layer = Hold(layer);
            Check(this.layer.Call(BalSlot.GetFeatures, &features));
            firmware = new Version(features.Major, features.Minor);
            var kinds = new VciBusType[features.Count];
            for (int at = 0; at < kinds.Length; at++)
                kinds[at] = BusTypes.Of(features.Types[at]);
            resources = kinds.Select((kind, at) => Resource(kinds, at)).ToArray();
        }

        public Version FirmwareVersion
        {
            get
            {
                Alive();
                return firmware;
            }
        }

        public BalResourceCollection Resources
        {
            get
            {
                Alive();
                return new BalResourceCollection(resources);
            }
        }

        public IBalResource OpenSocket(byte portNumber, Type socketType)
        {
            Alive();
            if (portNumber >= resources.Length)
                throw new ArgumentOutOfRangeException(
                    "portNumber", portNumber, "the board has connectors 0 to " + (resources.Length - 1));
            if (socketType == null)
                throw new ArgumentNullException("socketType");
            BalResource at = resources[portNumber];
            Func<BalResource, BalResource> make;
            var kinds = at.BusType == VciBusType.Can ? canKinds : linKinds;
            if (at.BusType == VciBusType.Unknown || !kinds.TryGetValue(socketType, out make))
                throw new NotImplementedException(at.BusName + " has no " + socketType.Name);
            BalResource made = make(at);
            try
            {
                made.Open(new Place(layer, at));
                return made;
            }
            catch
            {
                made.Dispose();
                throw;
            }
        }

        private static BalResource Resource(VciBusType[] kinds, int at)
        {
            int number = kinds.Take(at + 1).Count(kind => kind == kinds[at]);
            return new BalResource((byte)at, kinds[at], kinds[at].ToString().ToUpperInvariant() + "-" + number);
        }
    }

    /// <summary>Where an interface is to be opened.</summary>
    internal sealed unsafe class Place
    {
        private readonly NativeObject layer;

        private readonly BalResource at;

        internal Place(NativeObject layer, BalResource at)
        {
            this.layer = layer;
            this.at = at;
        }

        /// <summary>A new reference to the connector's interface, NotImplementedException where it has none of these.</summary>
        internal IntPtr Open(Guid iid)
        {
            IntPtr made;
            int result = layer.Call(BalSlot.OpenSocket, at.BusPort, &iid, &made);
            if (result == Results.NoInterface || result == Results.NotImplemented)
                throw new NotImplementedException(at.BusName + " has no such interface");
            Disposable.Check(result);
            return made;
        }
    }

    /// <summary>One connector; its number, kind and name can be read after Dispose, too.</summary>
    internal class BalResource : Disposable, IBalResource
    {
        internal BalResource(byte port, VciBusType kind, string name)
        {
            BusPort = port;
            BusType = kind;
            BusName = name;
        }

        internal BalResource(BalResource at) : this(at.BusPort, at.BusType, at.BusName)
        {
        }

        /// <summary>Open what this kind needs; the caller disposes of it if that fails.</summary>
        internal virtual void Open(Place place)
        {
        }

        public byte BusPort { get; private set; }

        public VciBusType BusType { get; private set; }

        public string BusName { get; private set; }

        public override string ToString()
        {
            return BusName;
        }
    }
}
